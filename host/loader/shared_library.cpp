// SPDX-License-Identifier: BSD-3-Clause
#include "loader/shared_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include "loader/plugin_call.h"
#include "model/error.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void refuse_library(const std::string& name, const std::string& fault) {
    throw Error(ExitCode::plugin_failure, fmt::format("plugin {}: {}", name, printable(fault)));
}

void check_file(const std::filesystem::path& file) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0)
        refuse_library(file, "there is no such file; --plugin wants the path of a shared library");
    if (!S_ISREG(status.st_mode)) refuse_library(file, "this is no regular file");
    if (status.st_mode & S_IWOTH) refuse_library(file, "everybody may write to this file; it is not loaded (chmod o-w)");
}

}  // namespace

SharedLibrary::SharedLibrary(const std::filesystem::path& file) : name_(file) {
    check_file(file);
    const std::filesystem::path path = std::filesystem::absolute(file);  // a bare name would be searched on the library path
    const PluginCall at_work(name_);
    const auto close = [name = name_](void* h) {
        const PluginCall closing(name);
        if (h) dlclose(h);
    };
    try {
        handle_.reset(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL), close);
    } catch (...) {
        refuse_library(name_, describe_exception());
    }
    if (!handle_) refuse_library(name_, dlerror());
    refuse_changed_arithmetic(name_);
}

void* SharedLibrary::symbol(const char* name) const { return dlsym(handle_.get(), name); }

}  // namespace dttmm::host
