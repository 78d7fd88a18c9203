// pairs.h: the pairs of images that LEFT and RIGHT on the command line mean.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "daemon/sources/pair_names.h"

namespace vdisp::calibrate {

/// A folder means the images in it, of the ending that most of them have; the rest is as in [image source] left.
std::string images_of(const std::string& name);
/// Throws SourceError.
std::vector<PairName> pairs_of(const std::string& left, const std::string& right);

}  // namespace vdisp::calibrate
