// model.cpp: maps a model file and checks all of it before anything is believed.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/snow/model.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <sstream>
#include <utility>

#include "daemon/snow/model_file.h"

namespace vdisp::snow {
namespace {

static_assert(std::endian::native == std::endian::little, "model files are little-endian and mapped as they are");

constexpr const char* smooth_names[] = {"none", "mean", "median"};

[[noreturn]] void wrong(const std::filesystem::path& path, const std::string& what) {
  throw ModelError(EX_CONFIG, path.string() + ": " + what);
}

const ModelHeader& header_of(const std::byte* memory) { return *reinterpret_cast<const ModelHeader*>(memory); }

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
  if (feature_spec(header.settings.encoding).width != columns || name(header.settings.encoding) == "unknown")
    wrong(path, "is of encoding " + std::to_string(static_cast<uint32_t>(header.settings.encoding)) + ", known are 1 to 4");
}

/// Numbers that nothing can be judged by: whoever made such a file, all its checksums are right.
void check_numbers(const std::filesystem::path& path, const ModelHeader& header) {
  const auto smooth = static_cast<uint32_t>(header.settings.smooth);
  if (smooth >= std::size(smooth_names)) wrong(path, "smooth is " + std::to_string(smooth) + ", known are 0 to 2");
  if (!std::isfinite(header.settings.confidence)) wrong(path, "confidence is no number");
  for (const Trained* trained : {&header.obstacle, &header.direction}) {
    const std::string of = trained == &header.obstacle ? " of free and obstacle" : " of left and right";
    if (!(trained->winnow.theta > 0) || !std::isfinite(trained->winnow.theta)) wrong(path, "theta" + of + " must be a number more than 0");
    if (!std::isfinite(trained->sensitivity)) wrong(path, "sensitivity" + of + " is no number");
  }
}

void check_weights(const std::filesystem::path& path, const float* weights) {
  constexpr const char* targets[] = {"free", "obstacle", "left", "right"};
  const float* end = weights + std::size(targets) * vector_length;
  const float* bad = std::find_if_not(weights, end, [](float weight) { return std::isfinite(weight); });
  if (bad == end) return;
  const auto number = static_cast<size_t>(bad - weights);
  wrong(path, "weight " + std::to_string(number % vector_length) + " of the target " + targets[number / vector_length] + " is no number");
}

/// "train" or "test", how often, which: what write_model() writes.
Source source_in(const std::filesystem::path& path, std::string_view line) {
  const size_t first = line.find('\t'), second = first == line.npos ? first : line.find('\t', first + 1);
  const bool three = second != line.npos;
  const std::string_view use = line.substr(0, first);
  Source source{three ? std::string(line.substr(second + 1)) : std::string(), 0, use == "test"};
  const char* end = three ? line.data() + second : line.data();
  const bool number = three && std::from_chars(line.data() + first + 1, end, source.weight).ptr == end && source.weight > 0;
  if (!number || source.folder.empty() || (use != "train" && use != "test"))
    wrong(path, "has a line in its list of recordings that is none: it must be train or test, how often, and a folder, with tabs between");
  return source;
}

std::vector<Source> sources_in(const std::filesystem::path& path, std::string_view text) {
  std::vector<Source> sources;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    sources.push_back(source_in(path, line));
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
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe is no file, and has nobody waited for
  if (file < 0) throw ModelError(errno == EACCES ? EX_NOPERM : EX_NOINPUT, path.string() + ": cannot be read: " + std::strerror(errno));
  struct stat status {};
  const bool regular = fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  Model model;
  model.path_ = path;
  model.bytes_ = regular ? static_cast<size_t>(status.st_size) : 0;
  void* memory = model.bytes_ ? mmap(nullptr, model.bytes_, PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
  close(file);
  if (memory == MAP_FAILED)
    wrong(path, model.bytes_ ? "cannot be mapped" : regular ? "is empty, needed is a model of vdisp-train" : "is no file");
  model.memory_ = static_cast<const std::byte*>(memory);

  check_header(path, model.memory_, model.bytes_);
  const ModelHeader& header = header_of(model.memory_);
  if (checksum(model.memory_ + model_page, model_weights_bytes) != header.weights_checksum)
    wrong(path, "is damaged: the checksum of its weights is wrong");
  check_numbers(path, header);
  check_weights(path, model.weights(0).data());
  const std::byte* list = model.memory_ + model_page + model_weights_bytes;
  const size_t rest = model.bytes_ - model_page - model_weights_bytes;
  if (checksum(list, rest) != header.sources_checksum) wrong(path, "is damaged: the checksum of its list of recordings is wrong");
  model.sources_ = sources_in(path, {reinterpret_cast<const char*>(list), rest});
  return model;
}

Model::Model(Model&& other) noexcept { *this = std::move(other); }

Model& Model::operator=(Model&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(memory_, other.memory_);
  std::swap(bytes_, other.bytes_);
  std::swap(sources_, other.sources_);
  return *this;
}

Model::~Model() {
  if (memory_) munmap(const_cast<std::byte*>(memory_), bytes_);
}

const Settings& Model::settings() const { return header_of(memory_).settings; }
const Trained& Model::obstacle_training() const { return header_of(memory_).obstacle; }
const Trained& Model::direction_training() const { return header_of(memory_).direction; }

void Model::require(const Settings& wanted, const std::string& where) const {
  const std::string found = differences(settings(), wanted);
  if (!found.empty()) wrong(path_, "was trained with another front end than that of " + where + ": " + found);
}

std::span<const float> Model::weights(int target) const noexcept {
  return {reinterpret_cast<const float*>(memory_ + model_page) + static_cast<size_t>(target) * vector_length, vector_length};
}

Model::Scores Model::obstacle(std::span<const uint32_t> ids) const noexcept {
  return {activation_of(weights(0), ids), activation_of(weights(1), ids)};
}

Model::Scores Model::direction(std::span<const uint32_t> ids) const noexcept {
  return {activation_of(weights(2), ids), activation_of(weights(3), ids)};
}

}  // namespace vdisp::snow
