// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

extern "C" void throw_exception();
extern "C" void throw_exception() { throw std::runtime_error("the spring has been thrown"); }
