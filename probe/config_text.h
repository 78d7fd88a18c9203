// config_text.h: parameters of a running daemon as a vdisp.cfg that gives the same values back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ipc/include/vdisp/control.h"

namespace vdisp {

/// A text or a path, whatever it holds; as it is, a $ would be a reference in it and " #" the beginning of a comment.
std::string in_quotes(const std::string& value);
/// The value as it is written in vdisp.cfg.
std::string written(const ParameterInfo& info);

/// Lines below the heads of their sections.
class ConfigText {
 public:
  /// `key`: SECTION.KEY; keys of one section one after the other.
  void add(const std::string& key, const std::string& written);
  const std::string& text() const { return text_; }

 private:
  std::string text_, section_;
};

}  // namespace vdisp
