// SPDX-License-Identifier: BSD-3-Clause
#include "cli/crash_report.h"

#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "loader/law_library.h"
#include "loader/plugin_call.h"
#include "model/error.h"
#include "record/csv_writer.h"

namespace dttmm::host {

namespace {

/// A line put together without memory from the heap, which may be what broke. What does not fit is cut.
class Line {
public:
    Line& operator<<(const char* text) {
        while (*text && size_ + 1 < sizeof text_) text_[size_++] = *text++;
        return *this;
    }
    /// In seconds, to the nanosecond, without zeros at the end. Magnitudes from 1e9 s on are left out.
    Line& operator<<(double seconds) {
        if (!(seconds >= 0 && seconds < 1e9)) return *this << "?";
        const auto nanoseconds = static_cast<uint64_t>(seconds * 1e9 + 0.5);
        char digits[32];
        char* end = digits + sizeof digits - 1;
        *end = '\0';
        char* begin = end;
        uint64_t rest = nanoseconds;
        for (int place = 0; place < 10 || rest > 0; ++place, rest /= 10) {
            if (place == 9) *--begin = '.';
            const auto digit = static_cast<char>('0' + rest % 10);
            if (digit == '0' && begin == end && place < 9) continue;
            *--begin = digit;
        }
        if (*(end - 1) == '.') *(end - 1) = '\0';
        return *this << begin;
    }
    void write() {
        text_[size_++] = '\n';
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text_, size_);
    }

private:
    char text_[2048];
    size_t size_ = 0;
};

const char* name_of(int signal) {
    switch (signal) {
        case SIGSEGV:
            return "it touched memory that is not its own, or its stack ran over (SIGSEGV)";
        case SIGBUS:
            return "it touched memory that is not there (SIGBUS)";
        case SIGFPE:
            return "arithmetic fault (SIGFPE)";
        case SIGILL:
            return "illegal instruction (SIGILL)";
        default:
            return "it called abort (SIGABRT)";
    }
}

[[noreturn]] void end_with(ExitCode code, Line& line) {
    line.write();
    CsvWriter::rescue_rows();
    ::_exit(static_cast<int>(code));
}

/// "plugin x.so, element "bolt1", t = 0.999 s: "
void name_plugin(Line& line, const PluginCall& call) {
    const dttmm_law* const law = *LawLibrary::at_work();
    if (law)
        line << "dttmm: law \"" << law->name << "\" of " << LawLibrary::file_of(law);
    else
        line << "dttmm: plugin " << call.plugin();
    if (call.element()) line << ", element \"" << call.element() << "\"";
    if (PluginCall::time() >= 0) line << ", t = " << PluginCall::time() << " s";
    line << ": ";
}

void on_fault(int signal) {
    Line line;
    const PluginCall* call = PluginCall::current();
    if (!call) {
        line << "dttmm: internal error of dttmm itself: " << name_of(signal) << "; please report it";
        end_with(ExitCode::internal_error, line);
    }
    name_plugin(line, *call);
    line << name_of(signal) << "; the rows written stay";
    end_with(ExitCode::plugin_failure, line);
}

bool is_watching = false;

/// Nothing of ours calls exit() while a command is at work: a plugin did.
void refuse_exit() {
    if (!is_watching) return;
    Line line;
    if (const PluginCall* call = PluginCall::current())
        name_plugin(line, *call);
    else
        line << "dttmm: a plugin: ";
    line << "it ended the process; the rows written stay";
    end_with(ExitCode::plugin_failure, line);
}

#ifdef __SANITIZE_ADDRESS__
constexpr bool kHandlesFaults = false;  // its own report says more
#else
constexpr bool kHandlesFaults = true;
#endif
constexpr int kFaults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
alignas(16) char handler_stack[64 * 1024];  // the handlers need 3 KiB of it; the system some 12 KiB for the registers

}  // namespace

CrashReport::CrashReport() {
    is_watching = true;
    [[maybe_unused]] static const int registered = std::atexit(refuse_exit) + std::at_quick_exit(refuse_exit);
    if (!kHandlesFaults) return;
    stack_t stack{};
    stack.ss_sp = handler_stack;
    stack.ss_size = sizeof handler_stack;
    ::sigaltstack(&stack, nullptr);
    struct sigaction action {};
    action.sa_handler = on_fault;
    action.sa_flags = SA_ONSTACK | static_cast<int>(SA_RESETHAND);  // the highest bit: no number of an int
    sigemptyset(&action.sa_mask);
    for (int signal : kFaults) sigaction(signal, &action, nullptr);
}

CrashReport::~CrashReport() {
    is_watching = false;
    if (!kHandlesFaults) return;
    for (int signal : kFaults) std::signal(signal, SIG_DFL);
    stack_t stack{};
    stack.ss_flags = SS_DISABLE;
    ::sigaltstack(&stack, nullptr);
}

}  // namespace dttmm::host
