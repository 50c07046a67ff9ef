// SPDX-License-Identifier: BSD-3-Clause
#include "report/html_text.h"

namespace dttmm::host {

std::string html_text(std::string_view text) {
    std::string html;
    for (const char c : text) {
        if (c == '&')
            html += "&amp;";
        else if (c == '<')
            html += "&lt;";
        else if (c == '>')
            html += "&gt;";
        else if (c == '"')
            html += "&quot;";
        else
            html += static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t' ? ' ' : c;
    }
    return html;
}

}  // namespace dttmm::host
