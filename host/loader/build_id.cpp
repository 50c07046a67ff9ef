// SPDX-License-Identifier: BSD-3-Clause
#include "loader/build_id.h"

#include <elf.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>

namespace dttmm::host {

namespace {

/// The build ID among the notes of one segment; empty: there is none. A note is a head, its name and its contents, each
/// filled up to a multiple of 4 bytes.
std::span<const uint8_t> id_among(std::span<const uint8_t> notes) {
    const auto filled = [](size_t size) { return (size + 3) & ~size_t{3}; };
    ElfW(Nhdr) head;
    while (notes.size() >= sizeof head) {
        std::memcpy(&head, notes.data(), sizeof head);
        const size_t contents = sizeof head + filled(head.n_namesz), next = contents + filled(head.n_descsz);
        if (next > notes.size()) break;
        const std::string_view name(reinterpret_cast<const char*>(notes.data() + sizeof head), head.n_namesz);
        if (head.n_type == NT_GNU_BUILD_ID && name == std::string_view("GNU\0", 4))
            return notes.subspan(contents, head.n_descsz);
        notes = notes.subspan(next);
    }
    return {};
}

struct Wanted {
    uintptr_t address;
    std::span<const uint8_t> id;
};

/// Called for each loaded object, as dl_iterate_phdr(3) says: 1 ends the search.
int look_into(dl_phdr_info* object, size_t, void* data) {
    auto& wanted = *static_cast<Wanted*>(data);
    const std::span segments(object->dlpi_phdr, object->dlpi_phnum);
    bool holds = false;
    for (const ElfW(Phdr) & segment : segments)
        holds |= segment.p_type == PT_LOAD && wanted.address - (object->dlpi_addr + segment.p_vaddr) < segment.p_memsz;
    if (!holds) return 0;
    for (const ElfW(Phdr) & segment : segments)
        if (segment.p_type == PT_NOTE && wanted.id.empty())
            wanted.id = id_among({reinterpret_cast<const uint8_t*>(object->dlpi_addr + segment.p_vaddr), segment.p_memsz});
    return 1;
}

}  // namespace

std::string build_id_at(const void* address) {
    Wanted wanted{reinterpret_cast<uintptr_t>(address), {}};
    dl_iterate_phdr(&look_into, &wanted);
    if (wanted.id.empty()) throw std::logic_error("dttmm was linked without --build-id");
    return fmt::format("{:02x}", fmt::join(wanted.id, ""));
}

}  // namespace dttmm::host
