// SPDX-License-Identifier: BSD-3-Clause
#include "identify/priors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "study/distribution.h"

namespace dttmm::host {

std::vector<Prior> read_priors(const std::vector<std::string>& texts, const Unknowns& unknowns,
                               const std::vector<Parameter>& parameters) {
    std::vector<Prior> priors;
    for (const std::string& text : texts) {
        const Variation variation = [&] {
            try {
                return parse_variation(text, parameters);
            } catch (const Error& error) {
                std::string why = error.what();
                if (const size_t at = why.find("--vary"); at != why.npos) why.replace(at, 6, "--prior");
                throw Error(error.code(), why);
            }
        }();
        const Distribution& own = variation.distribution;
        if (own.kind != Distribution::Kind::normal && own.kind != Distribution::Kind::lognormal)
            throw Error(ExitCode::usage,
                        fmt::format("--prior {}: it is normal(mean, deviation) or lognormal(mean, deviation); "
                                    "--bounds has ranges",
                                    quote(text)));
        for (const std::string& name : variation.names) {
            const auto found = std::ranges::find(unknowns.all(), name, &Unknown::name);
            if (found == unknowns.all().end())
                throw Error(ExitCode::usage, fmt::format("--prior {}: {} is not free", quote(text), quote(name)));
            Prior prior{as_size(found - unknowns.all().begin()), own.mean, own.deviation};
            if (own.kind == Distribution::Kind::lognormal) {
                const double share = own.deviation / own.mean;
                prior.deviation = std::sqrt(std::log1p(share * share));
                prior.mean = std::log(own.mean) - 0.5 * prior.deviation * prior.deviation;
                prior.is_of_logarithm = true;
            }
            priors.push_back(prior);
        }
    }
    return priors;
}

}  // namespace dttmm::host
