// pairs.cpp: folders become globs; the rest is the `files` source's business.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/pairs.h"

#include <sysexits.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "daemon/sources/source.h"

namespace vdisp::calibrate {

std::string images_of(const std::string& name) {
  std::error_code error;
  if (!std::filesystem::is_directory(name, error)) return name;
  constexpr const char* known[] = {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"};
  std::map<std::string, int> counts;
  for (const auto& entry : std::filesystem::directory_iterator(name, error)) {
    const std::string ending = entry.path().extension().string();
    if (std::find(std::begin(known), std::end(known), ending) != std::end(known)) ++counts[ending];
  }
  const auto most = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == counts.end()) throw SourceError(EX_NOINPUT, name + ": no images in this folder; needed are .png, .jpg, .pgm, .bmp or .tif");
  return (std::filesystem::path(name) / ("*" + most->first)).string();
}

std::vector<PairName> pairs_of(const std::string& left, const std::string& right) { return list_pairs(images_of(left), images_of(right)); }

}  // namespace vdisp::calibrate
