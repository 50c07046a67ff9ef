// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Marks what the library of oracles gives to the tests. Everything else in it is hidden.
#define DTTMM_ORACLE __attribute__((visibility("default")))
