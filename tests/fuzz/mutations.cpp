// mutations.cpp: feeds a fuzz target its seeds, each changed at random from fixed numbers, where there is no libFuzzer.
// SPDX-License-Identifier: Apache-2.0
//   PROGRAM ROUNDS FOLDER [numbers]     numbers: seeds hold binary numbers, which are put to their ends
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

/// What such files hold, and what breaks readers of numbers.
constexpr const char* words[] = {"nan",
                                 ".nan",
                                 "inf",
                                 "-1",
                                 "0",
                                 "1e308",
                                 "1e-320",
                                 "-1e999",
                                 "99999999999999999999",
                                 "[",
                                 "]",
                                 "{",
                                 ": ",
                                 "!!opencv-matrix",
                                 "\n",
                                 "\r\n",
                                 "- ",
                                 "#",
                                 "%YAML:1.0\n",
                                 "data",
                                 "rows: 99999",
                                 "\t",
                                 "\"",
                                 "'",
                                 "&a",
                                 "*a",
                                 "<",
                                 ">",
                                 "..."};

constexpr int64_t ends[] = {0, -1, 1, INT64_MIN, INT64_MAX, INT32_MAX, 0x7ff8000000000000, 0x7ff0000000000000};  // the last: NaN, infinite

void put_number(std::string& text, std::minstd_rand& random) {
  const size_t bytes = size_t{1} << random() % 4;
  if (text.size() < bytes) return;
  const int64_t number = ends[random() % std::size(ends)];
  const int64_t shifted = bytes == 4 && random() % 2 ? number >> 32 : number;
  std::memcpy(text.data() + random() % (text.size() - bytes + 1), &shifted, bytes);
}

void mutate(std::string& text, const std::vector<std::string>& seeds, std::minstd_rand& random) {
  const auto below = [&random](size_t n) { return n ? random() % n : 0; };
  const size_t at = below(text.size() + 1), length = below(1 + std::min<size_t>(text.size() - at, 40));
  switch (random() % 7) {
    case 0: text.erase(at, length); break;
    case 1: text.insert(at, words[below(std::size(words))]); break;
    case 2: text.replace(at, length, words[below(std::size(words))]); break;
    case 3: text.insert(at, text.substr(below(text.size() + 1), length)); break;
    case 4: text.resize(at); break;
    case 5:
      if (at < text.size()) text[at] = static_cast<char>(1 + random() % 255);
      break;
    default: {
      const std::string& other = seeds[below(seeds.size())];
      text.replace(at, length, other.substr(below(other.size() + 1), 60));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "needed are ROUNDS and FOLDER\n"), 64;
  const bool numbers = argc > 3;
  std::vector<std::string> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(argv[2])) {
    std::ifstream in(entry.path(), std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (seeds.empty()) return std::fprintf(stderr, "no seeds in %s\n", argv[2]), 66;
  std::minstd_rand random(1);
  const int rounds = std::atoi(argv[1]);
  for (int round = 0; round < rounds; ++round) {
    std::string text = seeds[random() % seeds.size()];
    if (round >= static_cast<int>(seeds.size()))
      for (unsigned n = 1 + random() % 4; n > 0; --n) numbers&& random() % 2 ? put_number(text, random) : mutate(text, seeds, random);
    else
      text = seeds[static_cast<size_t>(round)];
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  }
  std::printf("%d texts\n", rounds);
  return 0;
}
