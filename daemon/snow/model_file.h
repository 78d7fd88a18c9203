// model_file.h: the bytes of a model file: header of one page, four times 2^21 weights, list of recordings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "daemon/snow/model.h"

namespace vdisp::snow {

inline constexpr std::string_view model_magic = "VDSPSNOW";
inline constexpr uint32_t model_version = 2;
inline constexpr size_t model_page = 4096;  ///< the weights start on a page's border
inline constexpr size_t model_weights_bytes = 4 * vector_length * sizeof(float);

/// Numbers are little-endian. The rest of the page is 0. Checksums are CRC-32; that of the header is taken of the page with it as 0.
struct ModelHeader {
  std::array<char, 8> magic;
  uint32_t version, header_checksum;
  uint64_t file_bytes;
  uint32_t weights_checksum, sources_checksum;
  Settings settings;
  Trained obstacle, direction;
};
static_assert(sizeof(Settings) == 32 && sizeof(Winnow) == 56 && sizeof(Trained) == 112 && sizeof(ModelHeader) == 288);

uint32_t checksum(const void* bytes, size_t size);
/// Of the page that begins with this header.
uint32_t header_checksum(const ModelHeader& header);

/// What of these numbers no training can have made, or nothing can be decided with, and what would be right; empty: nothing.
std::string nonsense_in(const Settings& settings, const Trained& obstacle, const Trained& direction);
std::string nonsense_in(std::span<const float> weights);

}  // namespace vdisp::snow
