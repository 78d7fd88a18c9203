// comparison_page.h: old and new beside each other, and where they differ.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "probe/comparison.h"
#include "probe/paint.h"

namespace vdisp {

/// The stages as rows of three pictures below what was changed. `width` px, as high as it takes.
Picture comparison_page(const Comparison& comparison, const std::vector<const ComparedStage*>& stages, int width);

/// The stages by name; where `wanted` is empty those that tell most. Throws ProbeError (64) for one that was not made.
std::vector<const ComparedStage*> chosen_stages(const Comparison& comparison, const std::vector<std::string>& wanted);

/// "312 of 76800 px differ (0.4 %)"
std::string difference_words(const ComparedStage& stage);

}  // namespace vdisp
