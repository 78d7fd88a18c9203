// model_fuzz.cpp: any bytes as a model file of the second detector: refused in one line, or whole and of use.
// SPDX-License-Identifier: Apache-2.0
//
// An input is the file without its 2^23 weights: a byte that says what is put right (else a checksum would keep out all but the seeds), the
// header, four weights, which stand at the beginning of each target's, and the list of recordings.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <string>

#include "daemon/snow/model_file.h"
#include "tests/fuzz/require.h"

namespace vdisp::snow {
namespace {

enum Repair : uint8_t { begin = 1, length = 2, sums = 4, header_sum = 8, settings = 16, cut = 32 };

constexpr size_t target_bytes = vector_length * sizeof(float);

/// The file: in memory, mostly holes, and written anew only where inputs differ.
class ModelInMemory {
 public:
  ModelInMemory() : file_(memfd_create("a.model", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(file_)) {}
  const std::string& path() const { return path_; }
  void size(size_t bytes) const { require(ftruncate(file_, static_cast<off_t>(bytes)) == 0, "memory for a file"); }
  void write(const void* bytes, size_t count, size_t at) const {
    require(pwrite(file_, bytes, count, static_cast<off_t>(at)) == static_cast<ssize_t>(count), "memory for a file");
  }

 private:
  int file_;
  std::string path_;
};

/// Of four times a weight and zeros.
uint32_t weights_sum(const std::array<float, 4>& weights) {
  static const std::string zeros(target_bytes - sizeof(float), '\0');
  static const uLong zeros_sum = crc32_z(0, reinterpret_cast<const Bytef*>(zeros.data()), zeros.size());
  uLong sum = 0;
  for (const float& weight : weights) {
    sum = crc32_z(sum, reinterpret_cast<const Bytef*>(&weight), sizeof weight);
    sum = crc32_combine(sum, zeros_sum, static_cast<z_off_t>(zeros.size()));
  }
  return static_cast<uint32_t>(sum);
}

void put_right(ModelHeader& header, uint8_t how, const std::array<float, 4>& weights, const std::string& list) {
  if (how & begin) std::copy(model_magic.begin(), model_magic.end(), header.magic.begin()), header.version = model_version;
  if (how & length) header.file_bytes = model_page + model_weights_bytes + list.size();
  if (how & sums) header.weights_checksum = weights_sum(weights), header.sources_checksum = checksum(list.data(), list.size());
  if (how & settings) header.settings = Settings{};
  if (how & header_sum) header.header_checksum = header_checksum(header);
}

/// What the daemon makes of a model that it believes.
void use(const Model& model, const std::array<float, 4>& weights) {
  const Settings& settings = model.settings();
  require(name(settings.encoding) != "unknown", "its encoding is known");
  require(differences(settings, settings).empty(), "it is of use with its own settings: " + differences(settings, settings));
  model.require(settings, "itself");
  for (const Trained* trained : {&model.obstacle_training(), &model.direction_training()}) {
    require(std::isfinite(trained->winnow.theta) && trained->winnow.theta > 0, "theta divides");
    require(std::isfinite(trained->sensitivity), "a sensitivity is a number");
    require(std::isfinite(trained->clear) && trained->clear > 0, "clearness divides");
  }
  for (int target = 0; target < 4; ++target)
    require(model.weights(target)[0] == weights[static_cast<size_t>(target)], "weights are where they were");
  const std::array<uint32_t, 3> ids{0, vector_length - 1, 12345};
  for (const auto& [scores, trained] :
       {std::pair{model.obstacle(ids), &model.obstacle_training()}, std::pair{model.direction(ids), &model.direction_training()}})
    require(!std::isnan(Model::difference(scores, *trained) + trained->sensitivity), "a score can be judged by");
  for (const Source& source : model.sources())
    require(!source.folder.empty() && source.folder.find('\n') == std::string::npos && source.weight > 0, "a recording has a name");
}

void try_model(uint8_t how, Bytes bytes) {
  static const ModelInMemory file;
  alignas(ModelHeader) std::array<std::byte, model_page> page{};
  std::array<float, 4> weights{};
  bytes.copy(page.data(), sizeof(ModelHeader));
  bytes.copy(weights.data(), sizeof weights);
  const std::string list = bytes.text(bytes.size());
  auto& header = *reinterpret_cast<ModelHeader*>(page.data());
  put_right(header, how, weights, list);
  file.size(model_page + model_weights_bytes + list.size());
  file.write(page.data(), page.size(), 0);
  for (size_t target = 0; target < weights.size(); ++target)
    file.write(&weights[target], sizeof(float), model_page + target * target_bytes);
  if (!list.empty()) file.write(list.data(), list.size(), model_page + model_weights_bytes);
  if (how & cut) file.size(static_cast<size_t>(header.file_bytes % (model_page + model_weights_bytes)));
  try {
    use(Model::open(file.path()), weights);
  } catch (const ModelError& error) {
    require(is_one_line(error.what()), std::string("a refusal is one line: ") + error.what());
    require(error.exit_code == 78, "a file that is no model is wrong configuration");
  }
}

}  // namespace
}  // namespace vdisp::snow

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1 || size > 4096) return 0;
  vdisp::Bytes bytes(data, size);
  const auto how = bytes.number<uint8_t>();
  vdisp::snow::try_model(how, bytes);
  return 0;
}
