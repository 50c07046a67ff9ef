// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "analysis/modal_machine.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Shapes from a CSV file, and the MAC of the modes of a machine with them, |aᵀb|²/(aᵀa bᵀb). Displacements count; where a
/// shape has none its rotations do. A mode of several shapes counts with the nearest of their mixtures.
class GivenShapes {
public:
    /// The file is one of
    ///     modes.csv, shapes.csv   as `dttmm modes` writes them
    ///     others                  names of channels in the first column, plate.z, plate.rx or plate.position.z, then a
    ///                             column per shape under its name; a line of units may follow the names
    /// Throws Error(input_output), with file and line, for what is none of them, and for channels that the machine has not.
    /// Places of modes.csv and shapes.csv that it has not are left out, with a note.
    GivenShapes(const std::filesystem::path& file, const ModalMachine& machine, Warnings& warnings);

    /// Compares all modes.
    void compare(const Model& model, ModalMachine& machine, const std::vector<ModalInstance::Mode>& modes);

    /// mac.csv: a line per mode, a column per shape. A shape that has nothing to compare has empty fields.
    std::string table() const;
    void print() const;
    Json describe() const;

private:
    /// A place and direction, or a station along an element and a direction.
    struct Freedom {
        const ModalPlace* place;
        std::string element;
        int station;  ///< 0 … 20, of an element
        int direction;
    };
    struct CsvLine {
        size_t number;
        std::vector<std::string> fields;
    };

    std::vector<CsvLine> read_lines() const;
    void read_own(const std::vector<CsvLine>& lines, const ModalMachine& machine, Warnings& warnings);
    void read_plain(const std::vector<CsvLine>& lines, const ModalMachine& machine);
    Freedom freedom_named(size_t line, const std::string& channel, const ModalMachine& machine) const;
    double number(size_t line, const std::string& field) const;
    [[noreturn]] void fail(size_t line, const std::string& fault) const;
    Eigen::MatrixXd shapes_of(const Model& model, ModalMachine& machine,
                              const std::vector<ModalInstance::Mode>& modes) const;

    std::filesystem::path file_;
    std::vector<std::string> names_;
    std::vector<Freedom> freedoms_;
    Eigen::MatrixXd given_;            ///< a column per shape
    Eigen::MatrixXd mac_;              ///< a row per mode, a column per shape; NaN: nothing to compare
    std::vector<double> frequencies_;  ///< of the modes
};

}  // namespace dttmm::host
