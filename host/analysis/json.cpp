// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/json.h"

#include "record/atomic_file.h"

namespace dttmm {

void write_json(std::ostream& stream, const Json& json) {
    // Json::dump makes one text of it all, three times as large as what it describes
    nlohmann::detail::serializer<Json> serializer(nlohmann::detail::output_adapter<char>(stream), ' ',
                                                  Json::error_handler_t::replace);
    serializer.dump(json, true, false, 2);
    stream << '\n';
}

void write_json(const std::filesystem::path& path, const Json& json) {
    write_atomically(path, [&](std::ostream& stream) { write_json(stream, json); });
}

}  // namespace dttmm
