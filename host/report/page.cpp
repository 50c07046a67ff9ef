// SPDX-License-Identifier: BSD-3-Clause
#include "report/page.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "report/assets.h"
#include "report/base64.h"
#include "report/html_text.h"

namespace dttmm::host {

namespace {

/// As a content policy names a script or style that is allowed.
std::string source(const Asset& asset) {
    std::string bytes;
    for (std::size_t i = 0; i < asset.sha256.size(); i += 2)
        bytes += static_cast<char>(std::stoi(std::string(asset.sha256.substr(i, 2)), nullptr, 16));
    return fmt::format(" 'sha256-{}'", base64(bytes));
}

/// JSON in which no text can end the script element that it stands in.
std::string safe_json(const Json& data) {
    const std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string safe;
    safe.reserve(text.size());
    for (const char c : text)
        if (c == '<')
            safe += "\\u003c";
        else
            safe += c;
    return safe;
}

}  // namespace

std::string make_page(const std::string& title, const Json& data, bool has_machine) {
    std::vector<std::string_view> scripts = {"uplot.js", "numbers.js", "tables.js", "curves.js"};
    if (has_machine) scripts.insert(scripts.end(), {"three.js", "motion.js", "machine.js"});
    scripts.insert(scripts.end(), {"sections.js", "study.js", "verdict.js", "page.js"});
    std::string script_sources, style_sources, script_elements, style_elements;
    for (const std::string_view name : scripts) {
        const Asset& asset = report_asset(name);
        script_sources += source(asset);
        script_elements += fmt::format("<script>{}</script>\n", asset.text);
    }
    for (const std::string_view name : {"uplot.css", "page.css"}) {
        const Asset& asset = report_asset(name);
        style_sources += source(asset);
        style_elements += fmt::format("<style>{}</style>\n", asset.text);
    }
    const std::vector<std::pair<std::string_view, std::string>> parts = {
        {"{{policy}}", fmt::format("default-src 'none'; script-src{}; style-src{}; img-src data:; base-uri 'none'; "
                                   "form-action 'none'",
                                   script_sources, style_sources)},
        {"{{title}}", html_text(title)},
        {"{{styles}}", style_elements},
        {"{{licences}}", html_text(report_asset("licences.txt").text)},
        {"{{data}}", safe_json(data)},
        {"{{scripts}}", script_elements}};
    std::string_view rest = report_asset("page.html").text;
    std::string page = kReportBeginning;
    page += '\n';
    for (const auto& [mark, text] : parts) {
        const std::size_t place = rest.find(mark);
        page += rest.substr(0, place);
        page += text;
        rest.remove_prefix(place + mark.size());
    }
    page += rest;
    return page;
}

}  // namespace dttmm::host
