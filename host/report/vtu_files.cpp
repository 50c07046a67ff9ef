// SPDX-License-Identifier: BSD-3-Clause
#include "report/vtu_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/file.h"
#include "report/base64.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

using Eigen::Vector3d;

enum CellType : unsigned char { kVertex = 1, kPolyline = 4, kHexahedron = 12 };

/// Little-endian, as the machines that this is built for; base64_of_doubles relies on it too.
template <class Number>
std::string data_array(const char* type, const std::string& attributes, const std::vector<Number>& numbers) {
    const uint64_t size = numbers.size() * sizeof(Number);
    std::string bytes(sizeof(size) + size, '\0');
    std::memcpy(bytes.data(), &size, sizeof(size));
    if (size > 0) std::memcpy(bytes.data() + sizeof(size), numbers.data(), size);
    return fmt::format("<DataArray type=\"{}\" {} format=\"binary\">{}</DataArray>\n", type, attributes, base64(bytes));
}

/// Texts as VTK has them: codes of their bytes, each ended by a zero.
std::string text_array(const char* name, const std::vector<std::string>& texts) {
    std::string codes;
    for (const std::string& text : texts) {
        for (const char c : text) codes += fmt::format("{} ", static_cast<unsigned char>(c));
        codes += "0 ";
    }
    return fmt::format("<DataArray type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</DataArray>\n",
                       name, texts.size(), codes);
}

class Grid {
public:
    Grid(const Scene& scene, const Film& film, std::size_t time, double value);
    std::string text() const;

private:
    /// A point where it is drawn, and its displacement.
    void add_point(const Vector3d& at, const Vector3d& displacement) {
        for (const double number : at) points_.push_back(number);
        for (const double number : displacement) displacements_.push_back(number);
    }
    void add_owned(const OwnedPoint& point);
    /// Of the points since the last cell.
    void end_cell(CellType type, int kind, double force);

    const Scene& scene_;
    Instant instant_;
    bool is_mode_;
    double value_, frequency_;
    std::vector<double> points_, displacements_, forces_;
    std::vector<int64_t> connectivity_, offsets_;
    std::vector<uint8_t> types_, kinds_;
    std::vector<int32_t> parts_;
};

Grid::Grid(const Scene& scene, const Film& film, std::size_t time, double value)
    : scene_(scene),
      instant_(film.at(time)),
      is_mode_(film.kind == Film::Kind::mode),
      value_(value),
      frequency_(film.frequency) {
    const Structure& structure = scene.structure();
    for (std::size_t i = 0; i < structure.owners().size(); ++i) {
        const Owner& owner = structure.owners()[i];
        if (owner.box)
            for (const Vector3d& corner : corners_of(*owner.box)) add_owned({as_int(i), corner});
        else
            add_owned({as_int(i), Vector3d::Zero()});
        end_cell(owner.box ? kHexahedron : kVertex, owner.box ? 0 : 1, NAN);
    }
    const std::vector<std::vector<Vector3d>> lines = scene.place(instant_).lines,
                                             start = scene
                                                         .place({std::vector<Moved>(structure.owners().size()),
                                                                 std::vector<BentLine>(structure.elements().size()),
                                                                 {}})
                                                         .lines;
    for (std::size_t e = 0; e < structure.elements().size(); ++e) {
        const BentLine& bent = instant_.lines[e];
        const ElementLine& element = structure.elements()[e];
        if (!bent.start.empty())
            for (std::size_t s = 0; s < bent.start.size(); ++s)
                add_point(is_mode_ ? bent.start[s] : lines[e][s], bent.shift[s]);
        else if (is_mode_)
            for (const OwnedPoint& point : element.points) add_owned(point);
        else
            for (std::size_t s = 0; s < lines[e].size(); ++s) add_point(lines[e][s], lines[e][s] - start[e][s]);
        end_cell(element.points.size() < 2 ? kVertex : kPolyline, 2, instant_.forces[e]);
    }
}

void Grid::add_owned(const OwnedPoint& point) {
    const Vector3d start = scene_.structure().at_start(point);
    if (is_mode_)
        add_point(start, scene_.linear_shift(point, instant_));
    else
        add_point(scene_.place(point, instant_), scene_.place(point, instant_) - start);
}

void Grid::end_cell(CellType type, int kind, double force) {
    for (auto point = as_whole<int64_t>(connectivity_.size()); point < as_whole<int64_t>(points_.size() / 3); ++point)
        connectivity_.push_back(point);
    offsets_.push_back(as_whole<int64_t>(connectivity_.size()));
    types_.push_back(type);
    kinds_.push_back(static_cast<uint8_t>(kind));
    parts_.push_back(as_whole<int32_t>(parts_.size()));
    forces_.push_back(force);
}

std::string Grid::text() const {
    std::vector<std::string> names;
    for (const Owner& owner : scene_.structure().owners()) names.push_back(owner.name);
    for (const ElementLine& element : scene_.structure().elements()) names.push_back(element.name);
    std::string text =
        "<?xml version=\"1.0\"?>\n<!-- dttmm " DTTMM_VERSION
        " -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "<UnstructuredGrid>\n<FieldData>\n";
    text += data_array("Float64", "Name=\"TimeValue\" NumberOfTuples=\"1\"", std::vector<double>{value_});
    if (is_mode_) text += data_array("Float64", "Name=\"frequency\" NumberOfTuples=\"1\"", std::vector<double>{frequency_});
    text += text_array("part_names", names);
    if (!scene_.notes().empty()) text += text_array("left_out", scene_.notes());
    text += fmt::format(
        "</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData Vectors=\"displacement\">\n",
        points_.size() / 3, offsets_.size());
    text += data_array("Float64", "Name=\"displacement\" NumberOfComponents=\"3\"", displacements_);
    text += "</PointData>\n<CellData Scalars=\"force\">\n";
    text += data_array("Int32", "Name=\"part\"", parts_) + data_array("UInt8", "Name=\"kind\"", kinds_);
    text += data_array("Float64", "Name=\"force\"", forces_);
    text += "</CellData>\n<Points>\n" + data_array("Float64", "Name=\"Points\" NumberOfComponents=\"3\"", points_);
    text += "</Points>\n<Cells>\n" + data_array("Int64", "Name=\"connectivity\"", connectivity_);
    text += data_array("Int64", "Name=\"offsets\"", offsets_) + data_array("UInt8", "Name=\"types\"", types_);
    return text + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

bool is_frame(const fs::path& name) {
    const std::string text = name.string();
    return text.size() == 11 && text.starts_with('f') && text.ends_with(".vtu") &&
           std::ranges::all_of(text.substr(1, 6), [](char c) { return c >= '0' && c <= '9'; });
}

fs::path frame_name(std::size_t number) { return fmt::format("f{:06}.vtu", number); }

/// The folder, empty of frames of another time. Throws for one with anything else.
void make_frames_folder(const fs::path& folder) {
    std::error_code fault;
    fs::create_directories(folder, fault);
    if (fault) throw file_error(folder, "cannot make the folder", fault.value());
    std::vector<fs::path> frames;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, fault)) {
        if (!is_frame(entry.path().filename()))
            throw Error(
                ExitCode::input_output,
                fmt::format("{}: holds other files than frames of an export; choose another name with -o", folder.string()));
        frames.push_back(entry.path());
    }
    for (const fs::path& frame : frames) fs::remove(frame, fault);
}

}  // namespace

std::string write_vtu(const Scene& scene, const fs::path& path) {
    fs::path folder = path;
    folder.replace_extension(".frames");
    make_frames_folder(folder);
    std::string collection =
        "<?xml version=\"1.0\"?>\n<!-- dttmm " DTTMM_VERSION
        " -->\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
    std::size_t count = 0, bytes = 0;
    const std::string folder_name = folder.filename().string();
    const auto write = [&](const Film& film, std::size_t time, double value) {
        const std::string text = Grid(scene, film, time, value).text();
        bytes += text.size();
        write_atomically(folder / frame_name(count), text);
        std::string name;  // in an attribute
        for (const char c : folder_name + "/" + frame_name(count).string())
            name += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
        collection += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", number_text(value), name);
        ++count;
    };
    for (const Film& film : scene.films()) {
        if (film.kind == Film::Kind::run)
            for (std::size_t i = 0; i < film.times.size(); ++i) write(film, i, film.times[i]);
        else
            write(film, film.fullest, static_cast<double>(count + 1));
    }
    write_atomically(path, collection + "</Collection>\n</VTKFile>\n");
    std::string what = fmt::format("{} of {:.2f} MB in {}", counted(count, "frame", "frames"),
                                   static_cast<double>(bytes) / 1e6, folder_name);
    for (const std::string& note : scene.notes()) what += "\n" + note;
    return what;
}

}  // namespace dttmm::host
