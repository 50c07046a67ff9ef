/* SPDX-License-Identifier: BSD-3-Clause
 *
 * The interface's headers are C11 that stands alone: that this file compiles is the first half of the test. The second half
 * compares these sizes and places with those that C++ sees.
 */
#include "dttmm_derivative.h"
#include "dttmm_laws.h"
#include "dttmm_response.h"
#include "dttmm_shape.h"
#include "dttmm_state.h"
#include "dttmm_support.h"

const size_t dttmm_layout_in_c[] = {
    sizeof(dttmm_error),   sizeof(dttmm_parameter), sizeof(dttmm_element_type),      sizeof(dttmm_node),
    sizeof(dttmm_element), sizeof(dttmm_network),   sizeof(dttmm_motion),            sizeof(dttmm_step),
    sizeof(dttmm_channel), sizeof(dttmm_plugin),    offsetof(dttmm_plugin, outputs), offsetof(dttmm_network, gravity),
    sizeof(dttmm_body),    sizeof(dttmm_modal_model), sizeof(dttmm_modal_table),     sizeof(dttmm_response_table),
    sizeof(dttmm_state_table), sizeof(dttmm_laws_table),  sizeof(dttmm_shape_table),
    sizeof(dttmm_derivative_table),
};
