// write_model.cpp: a model file: complete beside its place, then renamed.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sysexits.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/snow/model_file.h"

namespace vdisp::snow {
namespace {

namespace fs = std::filesystem;

/// A file under another name until it is kept; gone if it is not.
class Part {
 public:
  explicit Part(const fs::path& path)
      : path_(path), part_(path.parent_path() / ("." + path.filename().string() + "." + std::to_string(getpid()) + ".part")) {
    file_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file_ < 0) fail("cannot be created");
  }
  ~Part() {
    if (file_ >= 0) close(file_);
    if (!kept_) unlink(part_.c_str());
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  void size(size_t bytes) {
    if (ftruncate(file_, static_cast<off_t>(bytes)) != 0) fail("cannot be written");
  }
  void write(const void* bytes, size_t size, size_t offset) {
    const auto* from = static_cast<const std::byte*>(bytes);
    for (size_t done = 0; done < size;) {
      const ssize_t now = pwrite(file_, from + done, size - done, static_cast<off_t>(offset + done));
      if (now < 0 && errno == EINTR) continue;
      if (now <= 0) fail("cannot be written");
      done += static_cast<size_t>(now);
    }
  }
  void keep() {
    if (fsync(file_) != 0) fail("cannot be written");
    if (rename(part_.c_str(), path_.c_str()) != 0) fail("cannot be replaced");
    kept_ = true;
    const fs::path parent = path_.parent_path();
    const int folder = open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;  // the file is whole; only a power cut would bring the old one back
    fsync(folder);
    close(folder);
  }

 private:
  [[noreturn]] void fail(const char* what) {
    const int error = errno;
    const bool broken = error == ENOSPC || error == EDQUOT || error == EIO || error == EFBIG;
    throw ModelError(broken ? EX_IOERR : EX_CANTCREAT, path_.string() + ": " + what + ": " + std::strerror(error));
  }

  fs::path path_, part_;
  int file_ = -1;
  bool kept_ = false;
};

/// Most features never occur: pages of zeros are holes in the file.
void write_weights(Part& part, std::span<const float> weights, size_t offset) {
  constexpr size_t chunk = model_page / sizeof(float);
  for (size_t i = 0; i < weights.size(); i += chunk) {
    const auto some = weights.subspan(i, std::min(chunk, weights.size() - i));
    if (std::any_of(some.begin(), some.end(), [](float weight) { return weight != 0; }))
      part.write(some.data(), some.size_bytes(), offset + i * sizeof(float));
  }
}

std::string text_of(const std::vector<Source>& sources) {
  std::string text;
  for (const Source& source : sources) {
    if (source.folder.find('\n') != std::string::npos)
      throw ModelError(EX_DATAERR, "a recording's name has a line break: '" + source.folder + "'; rename it");
    text += std::string(source.held_apart ? "test" : "train") + "\t" + std::to_string(source.weight) + "\t" + source.folder + "\n";
  }
  return text;
}

}  // namespace

void write_model(const fs::path& path, const ModelParts& parts) {
  const std::string sources = text_of(parts.sources);
  const std::span<const float> weights[] = {parts.free, parts.obstacles, parts.left, parts.right};
  alignas(ModelHeader) std::byte page[model_page] = {};
  ModelHeader& header = *new (page) ModelHeader{};
  std::copy(model_magic.begin(), model_magic.end(), header.magic.begin());
  header.version = model_version;
  header.settings = parts.settings;
  header.obstacle = parts.obstacle;
  header.direction = parts.direction;
  header.file_bytes = model_page + model_weights_bytes + sources.size();
  uLong sum = 0;
  const auto require = [&path](const std::string& nonsense) {
    if (!nonsense.empty())
      throw ModelError(EX_CONFIG, path.string() + ": is not written, nobody could use it: " + nonsense + "; train with other parameters");
  };
  require(nonsense_in(parts.settings, parts.obstacle, parts.direction));
  for (const auto& target : weights) {
    require(nonsense_in(target));
    if (target.size() != vector_length) throw std::logic_error("a model has 2^21 weights for each target");
    sum = crc32_z(sum, reinterpret_cast<const Bytef*>(target.data()), target.size_bytes());
  }
  header.weights_checksum = static_cast<uint32_t>(sum);
  header.sources_checksum = checksum(sources.data(), sources.size());
  header.header_checksum = header_checksum(header);

  Part part(path);
  part.size(header.file_bytes);
  for (size_t i = 0; i < 4; ++i) write_weights(part, weights[i], model_page + i * vector_length * sizeof(float));
  part.write(sources.data(), sources.size(), model_page + model_weights_bytes);
  part.write(page, sizeof page, 0);
  part.keep();
}

}  // namespace vdisp::snow
