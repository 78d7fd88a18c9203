// phrase.cpp: reads the text once; filling it is copying and std::to_chars.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/phrase.h"

#include <algorithm>
#include <charconv>
#include <cstring>

namespace vdisp::drive {
namespace {

constexpr const char* names[] = {"", "left", "right", "speed", "turn"};
constexpr int most_decimals = 6;

int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The byte that the escape at text[at] means; moves `at` to its last character.
char escape(std::string_view text, size_t& at) {
  const char kind = ++at < text.size() ? text[at] : '\0';
  if (kind == 'r') return '\r';
  if (kind == 'n') return '\n';
  if (kind == 't') return '\t';
  if (kind == '\\') return '\\';
  const int high = kind == 'x' && at + 2 < text.size() ? hexadecimal(text[at + 1]) : -1;
  const int low = high >= 0 ? hexadecimal(text[at + 2]) : -1;
  if (low < 0) throw PhraseError("'\\" + std::string(text.substr(at, 3)) + "' is no escape, must be \\r, \\n, \\t, \\\\ or \\xHH");
  at += 2;
  return static_cast<char>(high * 16 + low);
}

/// -0.3 with no decimals is 0, not -0.
bool only_zeros(const char* begin, const char* end) {
  return std::all_of(begin, end, [](char c) { return c == '0' || c == '.' || c == '-'; });
}

}  // namespace

Phrase::Part Phrase::field(std::string_view inside) {
  const size_t colon = inside.find(':');
  const std::string_view name = inside.substr(0, colon);
  const auto found = std::find(std::begin(names) + 1, std::end(names), name);
  if (found == std::end(names))
    throw PhraseError("no field {" + std::string(name) + "}, must be {left}, {right}, {speed} or {turn}; a plain { is written {{");
  Part part;
  part.field = static_cast<Field>(found - std::begin(names));
  part.decimals = part.field == Field::speed || part.field == Field::turn ? 3 : 0;
  if (colon == inside.npos) return part;
  const std::string_view format = inside.substr(colon + 1);
  if (format.size() != 2 || format[0] != '.' || format[1] < '0' || format[1] > '0' + most_decimals)
    throw PhraseError("{" + std::string(inside) + "}: after the colon must be a point and the decimals from 0 to 6, as {" +
                      std::string(name) + ":.2}");
  part.decimals = format[1] - '0';
  return part;
}

Phrase::Phrase(std::string_view text) {
  std::string plain;
  const auto end_text = [&] {
    if (!plain.empty()) parts_.push_back({plain, Field::none, 0});
    plain.clear();
  };
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\') {
      plain += escape(text, i);
    } else if ((c == '{' || c == '}') && i + 1 < text.size() && text[i + 1] == c) {
      plain += text[i++];
    } else if (c == '}') {
      throw PhraseError("a } without its {; a plain } is written }}");
    } else if (c == '{') {
      const size_t close = text.find('}', i);
      if (close == text.npos) throw PhraseError("the } of '" + std::string(text.substr(i)) + "' is missing; a plain { is written {{");
      end_text();
      parts_.push_back(field(text.substr(i + 1, close - i - 1)));
      i = close;
    } else {
      plain += c;
    }
  }
  end_text();
}

bool Phrase::has(Field field) const {
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) { return part.field == field; });
}

bool Phrase::has_fields() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.field != Field::none; });
}

bool Phrase::tells_motion() const { return (has(Field::left) && has(Field::right)) || (has(Field::speed) && has(Field::turn)); }

size_t Phrase::fill(const Motion& motion, std::span<char> to) const noexcept {
  const double values[] = {0, motion.left, motion.right, motion.speed, motion.turn};
  char* at = to.data();
  char* const end = at + to.size();
  for (const Part& part : parts_) {
    if (part.field == Field::none) {
      if (static_cast<size_t>(end - at) < part.text.size()) return 0;
      at = std::copy(part.text.begin(), part.text.end(), at);
      continue;
    }
    const auto number = std::to_chars(at, end, values[static_cast<int>(part.field)], std::chars_format::fixed, part.decimals);
    if (number.ec != std::errc()) return 0;
    const bool minus = *at == '-' && only_zeros(at, number.ptr);
    if (minus) std::memmove(at, at + 1, static_cast<size_t>(number.ptr - at - 1));
    at = number.ptr - (minus ? 1 : 0);
  }
  return static_cast<size_t>(at - to.data());
}

std::string escaped(std::string_view bytes) {
  constexpr const char* digits = "0123456789abcdef";
  std::string out;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\r') {
      out += "\\r";
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\\') {
      out += "\\\\";
    } else if (byte < 0x20 || byte >= 0x7f) {
      out += {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace vdisp::drive
