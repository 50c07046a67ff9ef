// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/// Where the tree and what is built of it lie. A generated source says so, not the command line of the compiler: the objects
/// of two clones are then the same, and the results of one serve the other.
namespace dttmm::test::paths {

std::string source_dir();
std::string binary_dir();
std::string command();             ///< dttmm
std::string library();             ///< the built-in plugin
std::string chain();               ///< tests/loader/chain
std::string jenkins();             ///< examples/minimal_law
std::string c_spring();            ///< examples/minimal_plugin
std::string faulty_plugins();      ///< the folder of those of tests/loader/faulty
std::string independent_spring();  ///< tests/abi/independent_spring.c
std::string nm();

}  // namespace dttmm::test::paths
