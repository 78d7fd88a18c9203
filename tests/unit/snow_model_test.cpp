// snow_model_test.cpp: a model file comes back as it was, and no damaged one is believed.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sysexits.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "daemon/snow/model.h"
#include "daemon/snow/model_file.h"
#include "tests/support/temporary_folder.h"

namespace vdisp::snow {
namespace {

namespace fs = std::filesystem;

struct Weights {
  std::vector<float> of[4];
  Weights() {
    for (size_t i = 0; i < 4; ++i) {
      of[i].resize(vector_length);
      for (uint32_t id = 0; id < vector_length; id += 100003) of[i][id] = static_cast<float>(id % 97 + 1) * static_cast<float>(i + 1);
      of[i][1309489] = static_cast<float>(i + 1) / 8;
    }
  }
};

ModelParts parts_of(const Weights& weights) {
  ModelParts parts;
  parts.settings.block = 7;
  parts.settings.confidence = 0.25;
  parts.settings.smooth = Smooth::median;
  parts.obstacle.sensitivity = -0.5;
  parts.obstacle.clear = 0.125;
  parts.obstacle.winnow.theta = 2;
  parts.direction.first = 4788;
  parts.free = weights.of[0], parts.obstacles = weights.of[1], parts.left = weights.of[2], parts.right = weights.of[3];
  parts.sources = {{"drives/office 7", 1, false}, {"drives/collision", 3, false}, {"drives/garage", 1, true}};
  return parts;
}

class ModelFile : public testing::Test {
 protected:
  ModelFile() { write_model(file_, parts_of(weights_)); }
  /// What open says of the file.
  std::string complaint() const {
    try {
      Model::open(file_);
    } catch (const ModelError& error) {
      EXPECT_EQ(error.exit_code, EX_CONFIG);
      return error.what();
    }
    return "";
  }
  void change(size_t byte) const {
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(byte));
    const char old = static_cast<char>(file.get());
    file.seekp(static_cast<std::streamoff>(byte));
    file.put(static_cast<char>(old ^ 0x10));
  }

  TemporaryFolder folder_;
  fs::path file_ = folder_ / "a.model";
  Weights weights_;
};

TEST_F(ModelFile, holds_what_was_written) {
  const Model model = Model::open(file_);
  EXPECT_EQ(model.settings(), parts_of(weights_).settings);
  EXPECT_EQ(model.obstacle_training().sensitivity, -0.5);
  EXPECT_EQ(model.obstacle_training().clear, 0.125);
  EXPECT_EQ(model.direction_training().first, 4788u);
  EXPECT_EQ(model.sources(), parts_of(weights_).sources);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::equal(weights_.of[i].begin(), weights_.of[i].end(), model.weights(i).begin())) << i;
  const uint32_t ids[] = {1309489, 100003};
  EXPECT_DOUBLE_EQ(model.obstacle(ids).first, 0.125 + 100003 % 97 + 1);
  EXPECT_DOUBLE_EQ(model.direction(ids).second, 0.5 + 4 * (100003 % 97 + 1));
  EXPECT_DOUBLE_EQ(Model::difference({5, 2}, model.obstacle_training()), 1.5);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(model.weights(0).data()) % 4096, 0u);
}

// cp onto the file of a running daemon truncates and then overwrites what it reads from.
TEST_F(ModelFile, that_is_open_stays_as_it_was_checked_whatever_becomes_of_its_file) {
  const Model model = Model::open(file_);
  const uint32_t ids[] = {1309489, 100003};
  Weights others;
  for (auto& weights : others.of) std::fill(weights.begin(), weights.end(), 7.f);
  ModelParts parts = parts_of(others);
  parts.obstacle.winnow.theta = 5;
  write_model(folder_ / "b.model", parts);
  {
    std::ifstream from(folder_ / "b.model", std::ios::binary);
    std::fstream(file_, std::ios::in | std::ios::out | std::ios::binary) << from.rdbuf();  // the same inode
  }
  EXPECT_DOUBLE_EQ(model.obstacle(ids).first, 0.125 + 100003 % 97 + 1);
  EXPECT_EQ(model.obstacle_training().winnow.theta, 2);
  fs::resize_file(file_, 0);
  EXPECT_DOUBLE_EQ(model.direction(ids).second, 0.5 + 4 * (100003 % 97 + 1));
  EXPECT_EQ(model.settings(), parts.settings);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::equal(weights_.of[i].begin(), weights_.of[i].end(), model.weights(i).begin())) << i;
}

TEST_F(ModelFile, same_parts_give_the_same_bytes_and_leave_nothing_else) {
  write_model(folder_ / "b.model", parts_of(weights_));
  const auto bytes = [](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(bytes(file_), bytes(folder_ / "b.model"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 2);
}

TEST_F(ModelFile, is_refused_with_any_byte_of_its_header_changed) {
  for (size_t byte = 0; byte < model_page; ++byte) {
    change(byte);
    ASSERT_NE(complaint(), "") << byte;
    change(byte);
  }
  EXPECT_EQ(complaint(), "");
}

TEST_F(ModelFile, is_refused_with_a_weight_or_its_list_changed) {
  for (const size_t byte :
       {model_page, model_page + 4 * 1309489ul, model_page + model_weights_bytes / 2 + 1, model_page + model_weights_bytes - 1}) {
    change(byte);
    EXPECT_NE(complaint().find("damaged: the checksum of its weights"), std::string::npos) << byte;
    change(byte);
  }
  change(model_page + model_weights_bytes + 5);
  EXPECT_NE(complaint().find("list of recordings"), std::string::npos);
}

TEST_F(ModelFile, is_refused_with_a_recording_that_has_no_name_or_no_weight) {
  for (const Source& source : {Source{"", 1, false}, Source{"drives/office", 0, true}}) {
    ModelParts parts = parts_of(weights_);
    parts.sources.push_back(source);
    write_model(file_, parts);
    EXPECT_NE(complaint().find("list of recordings"), std::string::npos) << source.folder;
  }
}

TEST_F(ModelFile, is_refused_cut_off_anywhere_or_with_more_behind_it) {
  const size_t whole = fs::file_size(file_);
  fs::resize_file(file_, whole + 1);
  EXPECT_NE(complaint().find("behind its end"), std::string::npos);
  for (const size_t bytes : {whole - 1, model_page + model_weights_bytes, model_page + 1, model_page}) {
    fs::resize_file(file_, bytes);
    EXPECT_NE(complaint().find("cut off: " + std::to_string(bytes)), std::string::npos) << complaint();
  }
  for (size_t bytes = model_page - 1; bytes > 0; --bytes) {
    fs::resize_file(file_, bytes);
    ASSERT_NE(complaint(), "") << bytes;
  }
  fs::resize_file(file_, 0);
  EXPECT_NE(complaint().find("is empty"), std::string::npos);
}

/// Changes the header, with the checksum that belongs to it.
template <class Change>
void rewrite_header(const fs::path& path, const Change& change) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  alignas(ModelHeader) std::array<char, model_page> page;
  file.read(page.data(), page.size());
  auto& header = *reinterpret_cast<ModelHeader*>(page.data());
  change(header);
  header.header_checksum = header_checksum(header);
  file.seekp(0).write(page.data(), page.size());
}

TEST_F(ModelFile, is_refused_with_numbers_that_decide_nothing_whatever_its_checksums_say) {
  const double infinite = std::numeric_limits<double>::infinity(), nan = std::nan("");
  const std::function<void(ModelHeader&)> changes[] = {
      [](ModelHeader& h) { h.obstacle.winnow.theta = 0; },
      [](ModelHeader& h) { h.direction.winnow.theta = -1; },
      [=](ModelHeader& h) { h.obstacle.winnow.theta = nan; },
      [=](ModelHeader& h) { h.direction.winnow.theta = infinite; },
      [=](ModelHeader& h) { h.obstacle.sensitivity = infinite; },
      [=](ModelHeader& h) { h.direction.sensitivity = nan; },
      [](ModelHeader& h) { h.obstacle.clear = 0; },
      [=](ModelHeader& h) { h.obstacle.clear = nan; },
      [=](ModelHeader& h) { h.obstacle.winnow.initial = nan; },
      [](ModelHeader& h) { h.settings.width = 0; },
      [](ModelHeader& h) { h.settings.height = 0; },
      [](ModelHeader& h) { h.settings.disparities = 0; },
      [](ModelHeader& h) { h.settings.block = 8; },
      [](ModelHeader& h) { h.settings.smooth = static_cast<Smooth>(3); },
      [](ModelHeader& h) { h.settings.encoding = static_cast<Encoding>(5); },
      [=](ModelHeader& h) { h.settings.confidence = nan; },
  };
  ModelHeader whole;
  rewrite_header(file_, [&](ModelHeader& h) { whole = h; });
  for (const auto& change : changes) {
    rewrite_header(file_, [&](ModelHeader& h) { change(h = whole); });
    EXPECT_NE(complaint().find("no usable model: "), std::string::npos) << &change - changes << ": " << complaint();
  }
  rewrite_header(file_, [&](ModelHeader& h) { h = whole, h.obstacle.auc = std::nan(""); });  // nothing was held apart
  EXPECT_EQ(complaint(), "");
}

TEST_F(ModelFile, with_a_weight_that_is_no_number_from_0_on_is_neither_read_nor_written) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity(), -1.f}) {
    write_model(file_, parts_of(weights_));
    {
      std::fstream(file_, std::ios::in | std::ios::out | std::ios::binary)
          .seekp(model_page + 3 * sizeof bad)
          .write(reinterpret_cast<const char*>(&bad), sizeof bad);
    }
    Weights changed = weights_;
    changed.of[0][3] = bad;
    uint32_t sum = 0;
    {
      std::ifstream file(file_, std::ios::binary);
      std::vector<char> bytes(model_weights_bytes);
      file.seekg(model_page).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      sum = checksum(bytes.data(), bytes.size());
    }
    rewrite_header(file_, [sum](ModelHeader& header) { header.weights_checksum = sum; });
    EXPECT_NE(complaint().find("no usable model: a weight is "), std::string::npos) << complaint();
    EXPECT_THROW(write_model(file_, parts_of(changed)), ModelError);
    EXPECT_NE(complaint(), "") << "the old one is still there";
  }
}

TEST_F(ModelFile, of_another_version_says_which) {
  std::fstream(file_, std::ios::in | std::ios::out | std::ios::binary).seekp(8).put(1);
  EXPECT_NE(complaint().find("is of version 1, needed is 2"), std::string::npos) << complaint();
}

TEST_F(ModelFile, of_another_front_end_names_all_that_differs) {
  const Model model = Model::open(file_);
  Settings wanted = model.settings();
  EXPECT_NO_THROW(model.require(wanted, "[census]"));
  wanted.encoding = Encoding::contour;
  wanted.width = 640, wanted.height = 480;
  wanted.block = 9;
  try {
    model.require(wanted, "[census]");
    FAIL();
  } catch (const ModelError& error) {
    EXPECT_EQ(error.what(), file_.string() +
                                ": was trained with another front end than that of [census]: encoding is depth-map and not contour, "
                                "size is 320x240 and not 640x480, block is 7 and not 9");
  }
}

TEST_F(ModelFile, missing_or_no_file_is_said) {
  EXPECT_THROW(Model::open(folder_ / "none"), ModelError);
  try {
    Model::open(folder_ / "none");
  } catch (const ModelError& error) {
    EXPECT_EQ(error.exit_code, EX_NOINPUT);
  }
  EXPECT_THROW(Model::open(folder_.path()), ModelError);
}

TEST_F(ModelFile, that_cannot_be_written_leaves_the_old_one) {
  EXPECT_THROW(write_model(folder_ / "no such folder" / "b.model", parts_of(weights_)), ModelError);
  ModelParts broken = parts_of(weights_);
  broken.sources = {{"a\nb", 1, false}};
  EXPECT_THROW(write_model(file_, broken), ModelError);
  EXPECT_EQ(complaint(), "");
  fs::create_directory(folder_ / "folder");
  EXPECT_THROW(write_model(folder_ / "folder", parts_of(weights_)), ModelError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 2);
}

}  // namespace
}  // namespace vdisp::snow
