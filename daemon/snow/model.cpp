// model.cpp: takes a copy of a model file and checks all of it before anything is believed.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/model.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>

#include "daemon/snow/model_file.h"

namespace vdisp::snow {
namespace {

static_assert(std::endian::native == std::endian::little, "model files are little-endian and used as they are");

constexpr const char* smooth_names[] = {"none", "mean", "median"};

[[noreturn]] void wrong(const std::filesystem::path& path, const std::string& what) {
  throw ModelError(EX_CONFIG, path.string() + ": " + what);
}

const ModelHeader& header_of(const std::byte* memory) { return *reinterpret_cast<const ModelHeader*>(memory); }

struct Closing {
  int file;
  ~Closing() { close(file); }
};

void check_header(const std::filesystem::path& path, const std::byte* memory, size_t bytes) {
  if (bytes < model_magic.size() || std::memcmp(memory, model_magic.data(), model_magic.size()) != 0)
    wrong(path, "no model of vdisp-train: it does not begin with " + std::string(model_magic));
  if (bytes < model_page)
    wrong(path, "is cut off: " + std::to_string(bytes) + " bytes, its header alone has " + std::to_string(model_page));
  const ModelHeader& header = header_of(memory);
  if (header.version != model_version)
    wrong(path, "is of version " + std::to_string(header.version) + ", needed is " + std::to_string(model_version) + "; train it again");
  if (header.header_checksum != header_checksum(header)) wrong(path, "is damaged: the checksum of its header is wrong");
  if (header.file_bytes != bytes)
    wrong(path, (bytes < header.file_bytes ? "is cut off: " : "has something behind its end: ") + std::to_string(bytes) +
                    " bytes, it should have " + std::to_string(header.file_bytes));
  if (bytes < model_page + model_weights_bytes) wrong(path, "is too short for its weights");
  if (const auto text = nonsense_in(header.settings, header.obstacle, header.direction); !text.empty())
    wrong(path, "no usable model: " + text);
}

std::vector<Source> sources_in(std::string_view text) {
  std::vector<Source> sources;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const size_t first = line.find('\t'), second = line.find('\t', first + 1);
    if (second == std::string_view::npos) continue;
    Source source{std::string(line.substr(second + 1)), 1, line.substr(0, first) == "test"};
    std::from_chars(line.data() + first + 1, line.data() + second, source.weight);
    sources.push_back(std::move(source));
  }
  return sources;
}

}  // namespace

uint32_t checksum(const void* bytes, size_t size) { return static_cast<uint32_t>(crc32_z(0, static_cast<const Bytef*>(bytes), size)); }

uint32_t header_checksum(const ModelHeader& header) {
  std::array<std::byte, model_page> page;
  std::memcpy(page.data(), &header, page.size());
  std::memset(page.data() + offsetof(ModelHeader, header_checksum), 0, sizeof header.header_checksum);
  return checksum(page.data(), page.size());
}

std::string differences(const Settings& found, const Settings& wanted) {
  std::ostringstream text;
  const auto add = [&text](const char* what, const auto& a, const auto& b) {
    if (a != b) text << (text.tellp() > 0 ? ", " : "") << what << " is " << a << " and not " << b;
  };
  const auto smooth = [](Smooth kind) { return smooth_names[std::min(static_cast<uint32_t>(kind), 2u)]; };
  const auto size = [](const Settings& s) { return std::to_string(s.width) + "x" + std::to_string(s.height); };
  add("encoding", name(found.encoding), name(wanted.encoding));
  add("size", size(found), size(wanted));
  add("search width", found.disparities, wanted.disparities);
  add("block", found.block, wanted.block);
  add("smooth", std::string_view(smooth(found.smooth)), std::string_view(smooth(wanted.smooth)));
  add("confidence", found.confidence, wanted.confidence);
  return text.str();
}

Model Model::open(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw ModelError(errno == EACCES ? EX_NOPERM : EX_NOINPUT, path.string() + ": cannot be read: " + std::strerror(errno));
  const Closing closing{file};
  struct stat status {};
  const bool regular = fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  const size_t bytes = regular ? static_cast<size_t>(status.st_size) : 0;
  if (!bytes) wrong(path, regular ? "is empty, needed is a model of vdisp-train" : "is no file");
  alignas(ModelHeader) std::array<std::byte, model_page> page{};
  const bool begun = pread(file, page.data(), page.size(), 0) >= 0;
  if (begun) check_header(path, page.data(), bytes);  // first: a file of any size may be named
  Model model;
  model.path_ = path;
  if (!begun || !model.copy_.fill(file, bytes)) throw ModelError(EX_NOINPUT, path.string() + ": cannot be read: " + std::strerror(errno));

  const std::byte* const memory = model.copy_.data();
  check_header(path, memory, model.copy_.size());
  const ModelHeader& header = header_of(memory);
  if (checksum(memory + model_page, model_weights_bytes) != header.weights_checksum)
    wrong(path, "is damaged: the checksum of its weights is wrong");
  const std::byte* list = memory + model_page + model_weights_bytes;
  const size_t rest = model.copy_.size() - model_page - model_weights_bytes;
  if (checksum(list, rest) != header.sources_checksum) wrong(path, "is damaged: the checksum of its list of recordings is wrong");
  for (int target = 0; target < 4; ++target)
    if (const auto text = nonsense_in(model.weights(target)); !text.empty()) wrong(path, "no usable model: " + text);
  model.sources_ = sources_in({reinterpret_cast<const char*>(list), rest});
  return model;
}

const Settings& Model::settings() const { return header_of(copy_.data()).settings; }
const Trained& Model::obstacle_training() const { return header_of(copy_.data()).obstacle; }
const Trained& Model::direction_training() const { return header_of(copy_.data()).direction; }

void Model::require(const Settings& wanted, const std::string& where) const {
  const std::string found = differences(settings(), wanted);
  if (!found.empty()) wrong(path_, "was trained with another front end than that of " + where + ": " + found);
}

std::span<const float> Model::weights(int target) const noexcept {
  return {reinterpret_cast<const float*>(copy_.data() + model_page) + static_cast<size_t>(target) * vector_length, vector_length};
}

Model::Scores Model::obstacle(std::span<const uint32_t> ids) const noexcept {
  return {activation_of(weights(0), ids), activation_of(weights(1), ids)};
}

Model::Scores Model::direction(std::span<const uint32_t> ids) const noexcept {
  return {activation_of(weights(2), ids), activation_of(weights(3), ids)};
}

}  // namespace vdisp::snow
