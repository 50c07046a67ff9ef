// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace dttmm::host {

/// While this lives, a process that is about to end without a word says why, in one line on the standard error:
/// - A fault of the processor or abort() (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) inside a plugin: plugin, element and
///   time; exit code 7. Elsewhere it is a fault of dttmm: exit code 8.
/// - exit() or quick_exit(), which nothing of ours calls meanwhile: the same line, exit code 7.
/// Rows that wait in memory are written first. A stack that has run over is no hindrance. _exit() cannot be caught. One at a
/// time.
class CrashReport {
public:
    CrashReport();
    ~CrashReport();
    CrashReport(const CrashReport&) = delete;
    CrashReport& operator=(const CrashReport&) = delete;
};

}  // namespace dttmm::host
