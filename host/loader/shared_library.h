// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace dttmm::host {

/// A shared library that the user named, open as long as a copy of this object lives.
class SharedLibrary {
public:
    /// Throws Error(plugin_failure) when it is missing, no regular file, writable for everybody, or no library of this
    /// machine.
    explicit SharedLibrary(const std::filesystem::path& file);

    const std::string& name() const { return name_; }
    /// What it exports by this name; NULL: nothing.
    void* symbol(const char* name) const;
    const std::shared_ptr<void>& handle() const { return handle_; }

private:
    std::string name_;
    std::shared_ptr<void> handle_;
};

}  // namespace dttmm::host
