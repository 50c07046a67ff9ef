// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "law/law.h"

namespace dttmm::plugin {

/// What the model file may say of the law of one direction, from the table of laws:
///     z = { law = "cubic", stiffness = "4 N/mm", cubic = "80 N/mm^3" }
/// One key names the law; then come the numbers that any law needs, each once.
class LawParameters {
public:
    /// direction: of x y z rx ry rz; good until a law is added, as what it declares.
    static const LawParameters& of_direction(int direction);
    /// Of an element that has one spring, between two points: keys without a direction, linear if no law is named.
    static const LawParameters& along_a_line();
    LawParameters(const LawParameters&) = delete;

    /// For the table of an element.
    const std::vector<dttmm_parameter>& declared() const { return declared_; }
    /// The law that the values of these name; none if they name none. Throws Error(DTTMM_ERROR_MODEL) where a number is
    /// missing or belongs to another law.
    std::unique_ptr<const Law> make(std::span<const double> values) const;
    /// Throws Error(DTTMM_ERROR_MODEL): `key` gives the direction a linear spring too.
    [[noreturn]] void refuse_stiffness(const char* key) const;

private:
    /// key: of the direction; empty: none, and the law that is meant if none is named is the first.
    LawParameters(const std::string& key, bool is_rotation);
    std::string full(const std::string& name) const { return key_.empty() ? name : key_ + "." + name; }

    std::string key_;
    bool is_rotation_;
    std::vector<std::string> names_;  ///< of the numbers, without the key
    std::vector<std::string> texts_;  ///< that declared_ points into
    std::vector<dttmm_word> words_;
    std::vector<dttmm_parameter> declared_;
};

/// What the values behind an element's own say of the law of each of six directions; null: none. Throws as make() does.
std::array<std::shared_ptr<const Law>, 6> laws_of_directions(std::span<const double> values);

/// An element type that has the parameters of laws behind its own: as many as there are laws.
class TypeWithLaws {
public:
    using Add = std::function<void(const LawParameters&)>;
    /// take(add): calls add for every direction that may have a law.
    TypeWithLaws(const dttmm_element_type& type, std::span<const dttmm_parameter> own, void (*take)(Add add))
        : type_(type), own_(own), take_(take) {}
    /// Good until a law is added.
    const dttmm_element_type& get();
    /// To be taken: the laws of six directions.
    static void all_directions(Add add);

private:
    dttmm_element_type type_;
    std::span<const dttmm_parameter> own_;
    void (*take_)(Add);
    size_t laws_ = 0;
    std::deque<std::vector<dttmm_parameter>> all_;  ///< what was handed out stays
};

}  // namespace dttmm::plugin
