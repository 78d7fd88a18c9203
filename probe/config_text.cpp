// config_text.cpp: sections, keys and quotes.
// SPDX-License-Identifier: Apache-2.0
#include "probe/config_text.h"

namespace vdisp {

std::string in_quotes(const std::string& value) {
  std::string text = "\"";
  for (const char letter : value) {
    if (letter == '"' || letter == '\\' || letter == '$') text += '\\';
    text += letter;
  }
  return text + '"';
}

std::string written(const ParameterInfo& info) {
  const bool words = info.allowed.starts_with("a text") || info.allowed.starts_with("a path");
  return words ? in_quotes(info.value) : info.value;
}

void ConfigText::add(const std::string& key, const std::string& written) {
  const size_t dot = key.rfind('.');
  if (const std::string section = key.substr(0, dot); section != section_) text_ += "[" + (section_ = section) + "]\n";
  text_ += key.substr(dot + 1) + " = " + written + "\n";
}

}  // namespace vdisp
