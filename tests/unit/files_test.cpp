// files_test.cpp: the files source gives every pair in order, calls bad ones bad, and refuses what cannot be a recording.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/files.h"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "ipc/outlet.h"
#include "ipc/recording.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

const std::filesystem::path data = VDISP_SHARED_DATA;
#define NEEDS(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << (path).string()

/// A picture that tells its number: the left one is brighter by 100.
cv::Mat picture(int number, bool left, int width = 64, int height = 48) {
  cv::Mat image(height, width, CV_8U, cv::Scalar(number * 10 + (left ? 100 : 0)));
  image.at<uint8_t>(height - 1, width - 1) = 255;
  return image;
}

/// A source with outlets to write to, as the driver would.
class Player {
 public:
  explicit Player(const Config& config) : source_(open_files(config)), specs_(source_->open()) {
    for (const ImageSpec& spec : specs_) outlets_.push_back(std::make_unique<BufferOutlet>(spec));
  }
  Outcome grab() {
    Image* images[2];
    for (int i : {0, 1}) images[i] = Image::make(&outlets_[i]->loan(), specs_[i]);
    return source_->grab(images);
  }
  /// Gray value of the top left corner, which is the picture's number.
  int value(int i) { return image(i).row<uint8_t>(0)[0]; }
  Image& image(int i) { return outlets_[i]->loan(); }
  StereoSource& source() { return *source_; }
  const ImageSpec& spec() const { return specs_[0]; }

  /// Outcomes until the end: numbers of good pairs, - for a bad one.
  std::string story(int most = 100) {
    std::string result;
    for (int i = 0; i < most; ++i) {
      const Outcome outcome = grab();
      if (outcome == Outcome::end) return result + ".";
      result += outcome == Outcome::valid ? std::to_string(value(1) / 10) : "-";
      if (outcome == Outcome::valid) {
        EXPECT_EQ(value(0) - value(1), 100) << "left and right of one pair";
      } else {
        EXPECT_EQ(image(0).reason, Reason::bad_pair);
      }
    }
    return result;
  }

 private:
  std::unique_ptr<StereoSource> source_;
  std::vector<ImageSpec> specs_;
  std::vector<std::unique_ptr<BufferOutlet>> outlets_;
};

class Files : public ::testing::Test {
 protected:
  void pair(int number, const std::string& name) {
    put("left/" + name, picture(number, true));
    put("right/" + name, picture(number, false));
  }
  void put(const std::string& name, const cv::Mat& image) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }
  Config config(const std::string& left, const std::string& right) {
    Config result;
    result.image_source.source = "files";
    result.image_source.left = (folder_ / left).string();
    if (!right.empty()) result.image_source.right = (folder_ / right).string();
    return result;
  }
  Config numbered() { return config("left/%06d.png", "right/%06d.png"); }
  void truncate(const std::string& name, double part = 0.7) {
    const auto file = folder_ / name;
    std::filesystem::resize_file(file, static_cast<uintmax_t>(static_cast<double>(std::filesystem::file_size(file)) * part));
  }
  void video(const std::string& name, int frames, cv::Size size, int first_value = 0) {
    cv::VideoWriter out((folder_ / name).string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 15, size);
    ASSERT_TRUE(out.isOpened());
    for (int i = 0; i < frames; ++i) out << cv::Mat(size, CV_8UC3, cv::Scalar::all(first_value + i * 10));
  }
  /// Overwrites the picture of a frame in an AVI that video() made.
  void spoil(const std::string& name, int frame) {
    std::fstream file(folder_ / name, std::ios::in | std::ios::out | std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    size_t at = bytes.find("movi");
    for (int i = 0; i <= frame; ++i) at = bytes.find("00dc", at + 4);
    ASSERT_NE(at, std::string::npos);
    uint32_t length;
    std::memcpy(&length, bytes.data() + at + 4, 4);
    file.seekp(static_cast<std::streamoff>(at + 8));
    file << std::string(length, '\0');
  }
  /// What open() says of a configuration, its exit code first; empty where it takes it.
  static std::string refusal(const Config& config) {
    try {
      open_files(config)->open();
    } catch (const SourceError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
      return std::to_string(e.exit_code) + " " + e.what();
    }
    return {};
  }
  TemporaryFolder folder_;
};
#define EXPECT_REFUSED(config, code, word)                             \
  do {                                                                 \
    const std::string said = refusal(config);                          \
    EXPECT_TRUE(said.starts_with(code)) << "said: " << said;           \
    EXPECT_NE(said.find(word), std::string::npos) << "said: " << said; \
  } while (false)

TEST_F(Files, numbered_pairs_come_in_order_and_end) {
  for (int i = 0; i < 12; ++i) pair(i, cv::format("%06d.png", i));
  EXPECT_EQ(Player(numbered()).story(), "01234567891011.");
}

TEST_F(Files, numbers_may_begin_at_one_and_need_no_zeros) {
  for (int i = 1; i < 4; ++i) pair(i, cv::format("%d.png", i));
  EXPECT_EQ(Player(config("left/%d.png", "right/%d.png")).story(), "123.");
}

TEST_F(Files, the_number_may_stand_in_a_folder_name) {
  for (int i = 1; i < 3; ++i) {
    put(cv::format("s%02d/left.png", i), picture(i, true));
    put(cv::format("s%02d/right.png", i), picture(i, false));
  }
  EXPECT_EQ(Player(config("s%02d/left.png", "s%02d/right.png")).story(), "12.");
}

TEST_F(Files, bad_pairs_are_invalid_and_the_run_goes_on) {
  for (int i = 0; i < 8; ++i) pair(i, cv::format("%06d.png", i));
  std::filesystem::remove(folder_ / "left/000001.png");  // missing
  truncate("right/000002.png");                          // truncated
  put("left/000003.png", picture(3, true, 32, 48));      // of two sizes
  put("left/000004.png", picture(4, true, 32, 48));      // both of another size
  put("right/000004.png", picture(4, false, 32, 48));
  folder_.write("left/000005.png", "no image");  // unreadable
  folder_.write("left/000006.png", "");          // empty
  Player run(numbered());
  EXPECT_EQ(run.story(7), "0------");
  EXPECT_FALSE(run.image(0).valid());
  EXPECT_EQ(run.image(0).row<uint8_t>(0)[0], 0) << "a blind image shows no old picture";
  EXPECT_EQ(run.source().files().first, (folder_ / "left/000006.png").string());
  EXPECT_EQ(run.story(), "7.");
}

TEST_F(Files, what_cannot_be_decoded_does_not_show_the_picture_before_it) {
  for (int i = 0; i < 5; ++i) pair(i, cv::format("%06d.png", i));
  folder_.write("left/000001.png", "no image");
  folder_.write("right/000003.png",
                std::string("\x89PNG\r\n\x1a\n", 8) + std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12));  // whole, and nothing in it
  EXPECT_EQ(Player(numbered()).story(), "0-2-4.");
  std::fstream png(folder_ / "left/000002.png", std::ios::in | std::ios::out | std::ios::binary);
  png.seekp(-30, std::ios::end);  // in the pixels: the checksum no longer fits
  png << "xxxx";
  png.close();
  EXPECT_EQ(Player(numbered()).story(), "0---4.");
}

TEST_F(Files, a_gap_is_a_bad_pair) {
  pair(0, "000000.png");
  pair(3, "000003.png");
  EXPECT_EQ(Player(numbered()).story(), "0--3.");
}

TEST_F(Files, bad_first_pairs_stay_in_the_sequence) {
  for (int i = 0; i < 3; ++i) pair(i, cv::format("%06d.png", i));
  truncate("left/000000.png");
  Player run(numbered());
  EXPECT_EQ(run.spec().width, 64);
  EXPECT_EQ(run.story(), "-12.");
}

TEST_F(Files, no_format_passes_cut_off_at_any_length) {
  cv::Mat noise(48, 64, CV_8UC3);
  cv::RNG random(1);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::Mat gray;
  cv::extractChannel(noise, gray, 0);
  for (const char* ending : {"png", "jpg", "pgm", "ppm", "bmp", "tif", "webp"}) {
    const std::string left = std::string("l.") + ending, right = std::string("r.") + ending, kept = std::string("k.") + ending;
    const cv::Mat picture = std::string_view(ending) == "pgm" ? gray : noise;
    put(right, picture);
    put(kept, picture);
    const auto size = std::filesystem::file_size(folder_ / kept);
    for (int part = 1; part < 40; ++part) {
      std::filesystem::copy_file(folder_ / kept, folder_ / left, std::filesystem::copy_options::overwrite_existing);
      std::filesystem::resize_file(folder_ / left, size * part / 40);
      Config two = config(std::string("[l]*.") + ending, std::string("[r]*.") + ending);
      EXPECT_EQ(refusal(two).substr(0, 2), "66") << ending << " cut at " << part << "/40";
    }
    std::filesystem::copy_file(folder_ / kept, folder_ / left, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(folder_ / left, size - 1);
    EXPECT_EQ(refusal(config(std::string("[l]*.") + ending, std::string("[r]*.") + ending)).substr(0, 2), "66")
        << ending << " without its last byte";
    std::filesystem::copy_file(folder_ / kept, folder_ / left, std::filesystem::copy_options::overwrite_existing);
    EXPECT_EQ(refusal(config(left, right)), "") << ending << " whole";
  }
}

TEST_F(Files, a_thumbnail_does_not_make_a_truncated_jpeg_whole) {
  // An APP1 segment that holds a whole small JPEG, as cameras write it.
  put("t.jpg", picture(1, true, 16, 16));
  put("l.jpg", picture(1, true));
  put("r.jpg", picture(1, false));
  const auto bytes = [this](const char* name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string thumbnail = bytes("t.jpg"), whole = bytes("l.jpg");
  const size_t length = thumbnail.size() + 2;
  const std::string with =
      whole.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) + static_cast<char>(length & 255) + thumbnail + whole.substr(2);
  folder_.write("l.jpg", with);
  EXPECT_EQ(refusal(config("l.jpg", "r.jpg")), "");
  folder_.write("l.jpg", with.substr(0, with.size() - 40));
  EXPECT_REFUSED(config("l.jpg", "r.jpg"), "66", "truncated");
}

TEST_F(Files, colour_becomes_gray_and_16_bit_becomes_8) {
  put("left.png", cv::Mat(48, 64, CV_8UC3, cv::Scalar(0, 255, 0)));  // green
  put("right.png", cv::Mat(48, 64, CV_16U, cv::Scalar(65535)));
  Player run(config("left.png", "right.png"));
  ASSERT_EQ(run.grab(), Outcome::valid);
  EXPECT_NEAR(run.value(0), 150, 1) << "0.587 of 255";
  EXPECT_EQ(run.value(1), 255);
  EXPECT_EQ(run.grab(), Outcome::end);
}

TEST_F(Files, files_of_10_and_12_bit_keep_their_contrast_for_the_whole_run) {
  const auto values = [this](int first, int second) {
    for (const char* side : {"left", "right"}) {
      put(cv::format("%s/0.png", side), cv::Mat(48, 64, CV_16U, cv::Scalar(first)));
      for (int i = 1; i < 11; ++i) put(cv::format("%s/%d.png", side, i), cv::Mat(48, 64, CV_16U, cv::Scalar(second)));
      put(cv::format("%s/11.png", side), cv::Mat(48, 64, CV_16U, cv::Scalar(50000)));
    }
    Player run(config("left/%d.png", "right/%d.png"));
    std::vector<int> result;
    while (run.grab() == Outcome::valid) result.push_back(run.value(0));
    return std::vector<int>{result.at(0), result.at(1), result.at(11)};
  };
  EXPECT_EQ(values(2048, 4095), (std::vector{128, 255, 255}));
  EXPECT_EQ(values(512, 1023), (std::vector{128, 255, 255}));
  EXPECT_EQ(values(512, 4096), (std::vector{2, 16, 195}));
  EXPECT_EQ(values(0, 0), (std::vector{0, 0, 195})) << "black tells nothing";
}

TEST_F(Files, a_stray_first_pair_does_not_make_the_others_bad) {
  for (int i = 1; i < 4; ++i) pair(i, cv::format("%06d.png", i));
  put("left/000000.png", picture(0, true, 40, 20));
  put("right/000000.png", picture(0, false, 40, 20));
  Player run(numbered());
  EXPECT_EQ(run.story(1), "-");
  EXPECT_EQ(run.source().fault(), (folder_ / "left/000000.png").string() + " is 40x20, not 64x48 as the others");
  EXPECT_EQ(run.story(), "123.");
  EXPECT_EQ(run.source().fault(), "");
}

TEST_F(Files, the_size_that_is_asked_for_goes_before_the_majority) {
  for (int i = 0; i < 3; ++i) pair(i, cv::format("%06d.png", i));
  put("left/000003.png", picture(3, true, 40, 20));
  put("right/000003.png", picture(3, false, 40, 20));
  Config small = numbered();
  small.image_source.width = 40;
  EXPECT_EQ(Player(small).story(), "---3.");
  small.image_source.width = 41;
  EXPECT_REFUSED(small, "78", "images are 64x48, needed by width and height is 41x48");
  small.image_source.width = 0;
  small.image_source.paramfile = folder_
                                     .write("c.yml",
                                            "%YAML:1.0\n---\nimage_width: 40\nimage_height: 20\n"
                                            "P1: [ 50., 0., 32., 0., 0., 50., 24., 0., 0., 0., 1., 0. ]\n"
                                            "P2: [ 50., 0., 30., -5., 0., 50., 24., 0., 0., 0., 1., 0. ]\n")
                                     .string();
  EXPECT_EQ(Player(small).story(), "---3.");
}

TEST_F(Files, a_bad_pair_is_told_by_fault_and_nothing_is_written) {
  for (int i = 0; i < 3; ++i) pair(i, cv::format("%06d.png", i));
  truncate("right/000001.png");
  testing::internal::CaptureStderr();
  Player run(numbered());
  std::vector<std::string> faults;
  do {
    faults.emplace_back(run.grab() == Outcome::end ? "end" : run.source().fault());
  } while (faults.back() != "end");
  EXPECT_EQ(faults, (std::vector<std::string>{"", (folder_ / "right/000001.png").string() + " is truncated", "", "end"}));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Files, globs_pair_by_name_and_sort_numbers_as_numbers) {
  for (int i : {1, 2, 10}) {
    put(cv::format("left%d.png", i), picture(i, true));
    put(cv::format("right%d.pgm", i), picture(i, false));
  }
  EXPECT_EQ(Player(config("left*.png", "right*.pgm")).story(), "1210.");
  std::filesystem::remove(folder_ / "right2.pgm");
  EXPECT_EQ(Player(config("left*.png", "right*.pgm")).story(), "1-10.") << "a name without its other half is a bad pair";
}

TEST_F(Files, globs_without_common_names_pair_by_order) {
  for (int i = 0; i < 3; ++i) {
    put(cv::format("left/a%d.png", i), picture(i, true));
    put(cv::format("right/b%d.png", i), picture(i, false));
  }
  EXPECT_EQ(Player(config("left/*.png", "right/*.png")).story(), "012.");
  put("left/a3.png", picture(3, true));
  EXPECT_REFUSED(config("left/*.png", "right/*.png"), "78", "matches 4 images");
}

TEST_F(Files, leading_folders_are_taken_by_their_names) {
  for (const char* folder : {"br[1]", "pc%20", "a%%b", "back\\*"})
    for (int i = 0; i < 3; ++i) {
      put(cv::format("%s/left/%06d.png", folder, i), picture(i, true));
      put(cv::format("%s/right/%06d.png", folder, i), picture(i, false));
    }
  for (const std::string folder : {"br[1]", "pc%20", "a%%b", "back\\*"})
    for (const std::string names : {"%06d.png", "*.png"})
      EXPECT_EQ(Player(config(folder + "/left/" + names, folder + "/right/" + names)).story(), "012.") << folder << " " << names;
}

TEST_F(Files, two_percent_signs_are_a_plain_one) {
  for (int i = 0; i < 3; ++i) {
    put(cv::format("pc%%20/left/5%%_%d_%%.png", i), picture(i, true));
    put(cv::format("pc%%20/right/5%%_%d_%%.png", i), picture(i, false));
  }
  EXPECT_EQ(Player(config("pc%%20/left/5%%_%d_%%.png", "pc%%20/right/5%%_%d_%%.png")).story(), "012.");
  EXPECT_EQ(Player(config("pc%%20/left/5%%_*.png", "pc%20/right/5%%_*.png")).story(), "012.");
  EXPECT_REFUSED(config("pc%20/left/5%_%d.png", "pc%20/right/*"), "78", "two of a kind");
  EXPECT_REFUSED(config("pc%20/left/5%_%d.png", "pc%20/right/%d"), "78", "a plain % is written %%");
}

TEST_F(Files, loop_begins_again_with_rising_timestamps) {
  for (int i = 0; i < 2; ++i) pair(i, cv::format("14037152730%08d.png", i * 50000000));
  Config looped = config("left/*.png", "right/*.png");
  looped.image_source.loop = true;
  Player run(looped);
  int64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(run.grab(), Outcome::valid);
    EXPECT_EQ(run.value(1), i % 2 * 10);
    if (i > 0) {
      EXPECT_EQ(run.image(0).timestamp_ns - last, 50'000'000);
    }
    last = run.image(0).timestamp_ns;
  }
}

TEST_F(Files, timestamps_come_from_names_rate_or_thirty_a_second) {
  for (int i = 0; i < 2; ++i) pair(i, cv::format("%06d.png", i));
  const auto second = [](const Config& config) {
    Player run(config);
    run.grab();
    run.grab();
    EXPECT_EQ(run.image(0).timestamp_ns, run.image(1).timestamp_ns);
    return run.image(0).timestamp_ns;
  };
  EXPECT_EQ(second(numbered()), 33'333'333);
  Config slow = numbered();
  slow.image_source.rate = 10;
  EXPECT_EQ(second(slow), 100'000'000);
  EXPECT_EQ(Player(slow).source().period_ns(), 100'000'000);
  EXPECT_EQ(Player(numbered()).source().period_ns(), 0);
}

TEST_F(Files, images_carry_synthetic_geometry_and_the_calibrations_hash) {
  pair(1, "000001.png");
  Config calibrated = numbered();
  calibrated.image_source.paramfile =
      folder_
          .write(
              "c.yml",
              "%YAML:1.0\n---\nimage_width: 64\nimage_height: 48\n"
              "P1: [ 50., 0., 32., 0., 0., 50., 24., 0., 0., 0., 1., 0. ]\nP2: [ 50., 0., 30., -5., 0., 50., 24., 0., 0., 0., 1., 0. ]\n")
          .string();
  calibrated.image_source.minDisparity = 3;
  Player run(calibrated);
  ASSERT_EQ(run.grab(), Outcome::valid);
  for (int i : {0, 1}) {
    EXPECT_EQ(run.image(i).flags, flag_synthetic);
    EXPECT_EQ(run.image(i).calibration_hash, run.source().calibration()->hash);
    EXPECT_EQ(run.image(i).camera.baseline, 0) << "the geometry is that of rectified views";
    EXPECT_EQ(run.image(i).camera.disparities, 0);
  }
  put("left/000001.png", picture(1, true, 80, 48));
  put("right/000001.png", picture(1, false, 80, 48));
  EXPECT_REFUSED(calibrated, "78", "is for 64x48");
  calibrated.image_source.paramfile = (folder_ / "none.yml").string();
  EXPECT_THROW(open_files(calibrated), CalibrationError);
}

TEST_F(Files, sizes_are_checked_against_the_configuration) {
  pair(1, "000001.png");
  Config wide = numbered();
  wide.image_source.width = 640;
  EXPECT_REFUSED(wide, "78", "images are 64x48, needed by width and height is 640x48");
}

TEST_F(Files, what_names_no_recording_is_refused) {
  pair(0, "000000.png");
  const auto with = [this](const std::string& left, const std::string& right) { return refusal(config(left, right)); };
  Config none;
  EXPECT_REFUSED(none, "78", "left is empty");
  EXPECT_REFUSED(config("left/%06d.png", ""), "78", "right is empty");
  EXPECT_REFUSED(config("left/%06d.png", "right/*.png"), "78", "two of a kind");
  EXPECT_REFUSED(config("absent/%06d.png", "right/%06d.png"), "66", "there is no folder");
  EXPECT_REFUSED(config("left/%04d.jpg", "right/%06d.png"), "66", "holds 1 name: 000000.png");
  EXPECT_REFUSED(config("left/*.jpg", "right/*.jpg"), "66", "no such image");
  EXPECT_REFUSED(config("left/000000.png", "right/000009.png"), "66", "no such file");
  EXPECT_REFUSED(config("left", "right"), "78", "is a folder");
  for (const char* wrong : {"left/%s.png", "left/%n", "left/%d%d.png", "left/%-6d.png", "left/%123456789d.png", "left/%", "left/%06",
                            "left/%*d", "left/%06ld.png"})
    EXPECT_EQ(with(wrong, "right/%06d.png").substr(0, 2), "78") << wrong << ": " << with(wrong, "right/%06d.png");
  pair(0, "1403715273262142976.png");
  pair(0, "5.png");
  EXPECT_REFUSED(config("left/%d.png", "right/%d.png"), "78", "needed is a glob");
  folder_.write("left/5.png", "no image");
  EXPECT_REFUSED(config("left/?.png", "right/?.png"), "66", "none of 1 pairs is good");
}

TEST_F(Files, two_videos_end_with_the_shorter) {
  video("l.avi", 5, {64, 48}, 100);
  video("r.avi", 4, {64, 48});
  Player run(config("l.avi", "r.avi"));
  int64_t frames = 0;
  while (run.grab() == Outcome::valid) {
    EXPECT_NEAR(run.value(0), 100 + 10 * static_cast<double>(frames), 4);
    EXPECT_NEAR(run.value(1), 10 * static_cast<double>(frames), 4);
    EXPECT_EQ(run.image(0).timestamp_ns, (frames * 1'000'000'000 + 7) / 15) << "the recording's 15 frames per second";
    ++frames;
  }
  EXPECT_EQ(frames, 4);
  EXPECT_EQ(run.source().fault(), (folder_ / "r.avi").string() + " ends after 4 frames, before the other view");
}

TEST_F(Files, damage_within_a_video_makes_bad_pairs_and_the_views_stay_in_step) {
  video("l.avi", 10, {64, 48}, 100);
  video("r.avi", 10, {64, 48});
  spoil("l.avi", 3);
  spoil("l.avi", 4);
  spoil("r.avi", 7);
  testing::internal::CaptureStderr();
  Player run(config("l.avi", "r.avi"));
  std::string story, faults;
  for (int i = 0; i < 20; ++i) {
    const Outcome outcome = run.grab();
    if (outcome == Outcome::end) break;
    if (outcome == Outcome::valid) {
      EXPECT_NEAR(run.value(0) - run.value(1), 100, 4) << "frame " << i;
      EXPECT_NEAR(run.value(1), 10 * i, 4);
    } else {
      faults += std::string(run.source().fault()) + "\n";
    }
    story += outcome == Outcome::valid ? "+" : "-";
  }
  EXPECT_EQ(story, "+++--++-++");
  const std::string left = (folder_ / "l.avi").string() + ": frame ", right = (folder_ / "r.avi").string() + ": frame ";
  EXPECT_EQ(faults, left + "3 is damaged or missing\n" + left + "4 is damaged or missing\n" + right + "7 is damaged or missing\n");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "FFmpeg has nothing to say beside fault()";
}

TEST_F(Files, one_video_holds_both_views_and_loops) {
  cv::VideoWriter out((folder_ / "both.avi").string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 15, {128, 48});
  for (int i = 0; i < 3; ++i) {
    cv::Mat frame(48, 128, CV_8UC3, cv::Scalar::all(200));
    frame.colRange(64, 128) = cv::Scalar::all(10 * i);
    out << frame;
  }
  out.release();
  Config looped = config("both.avi", "");
  looped.image_source.loop = true;
  Player run(looped);
  EXPECT_EQ(run.spec().width, 64);
  for (int i = 0; i < 7; ++i) {
    ASSERT_EQ(run.grab(), Outcome::valid);
    EXPECT_NEAR(run.value(0), 200, 4);
    EXPECT_NEAR(run.value(1), 10 * (i % 3), 4);
  }
}

TEST_F(Files, videos_that_do_not_fit_are_refused) {
  video("l.avi", 3, {64, 48});
  video("wide.avi", 3, {128, 48});
  EXPECT_REFUSED(config("l.avi", "wide.avi"), "78", "right");
  folder_.write("text.avi", "no video at all");
  EXPECT_REFUSED(config("text.avi", "l.avi"), "66", "text.avi");
  EXPECT_REFUSED(config("l.avi", "text.avi"), "66", "text.avi");
  folder_.write("empty.avi", "");
  EXPECT_REFUSED(config("empty.avi", ""), "66", "empty.avi");
}

TEST(Source, auto_without_a_camera_ends_with_69_and_names_sim) {
  try {
    open_source(Config{});
    FAIL() << "took a camera";
  } catch (const SourceError& e) {
    EXPECT_EQ(e.exit_code, 69);
    EXPECT_NE(std::string(e.what()).find("--sim"), std::string::npos) << e.what();
  }
}

TEST(FilesData, robot_indoor_has_228_pairs_and_repeats_bit_by_bit) {
  const auto set = data / "robot_indoor";
  NEEDS(set);
  Config config;
  config.image_source.left = (set / "robotL.mp4").string();
  config.image_source.right = (set / "robotR.mp4").string();
  config.image_source.paramfile = (set / "calibration.yml").string();
  uint64_t hashes[2] = {0, 0};
  for (uint64_t& hash : hashes) {
    Player run(config);
    int frames = 0;
    while (run.grab() == Outcome::valid) {
      ++frames;
      for (int i : {0, 1})
        for (int y = 0; y < run.spec().height; ++y)
          for (int x = 0; x < run.spec().width; x += 7) hash = (hash ^ run.image(i).row<uint8_t>(y)[x]) * 0x100000001b3;
    }
    EXPECT_EQ(frames, 228);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(FilesData, forty_kilobytes_of_damage_in_robot_indoor_cost_those_frames_alone) {
  const auto set = data / "robot_indoor";
  NEEDS(set);
  TemporaryFolder folder;
  std::filesystem::copy_file(set / "robotL.mp4", folder / "l.mp4");
  const auto size = std::filesystem::file_size(folder / "l.mp4");
  std::fstream file(folder / "l.mp4", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 4));
  file << std::string(40000, '\0');
  file.close();
  Config config, whole;
  config.image_source.left = (folder / "l.mp4").string();
  config.image_source.right = whole.image_source.left = whole.image_source.right = (set / "robotR.mp4").string();
  whole.image_source.left = (set / "robotL.mp4").string();
  Player run(config), reference(whole);
  int good = 0, pairs = 0;
  for (Outcome outcome; (outcome = run.grab()) != Outcome::end; ++pairs) {
    ASSERT_EQ(reference.grab(), Outcome::valid);
    if (outcome != Outcome::valid) continue;
    ++good;
    const size_t bytes = static_cast<size_t>(run.spec().stride()) * run.spec().height;
    EXPECT_EQ(std::memcmp(run.image(1).row<uint8_t>(0), reference.image(1).row<uint8_t>(0), bytes), 0) << "right frame " << pairs;
    if (pairs < 55) {  // from there on the decoder patches: there is one whole picture, the first
      EXPECT_EQ(std::memcmp(run.image(0).row<uint8_t>(0), reference.image(0).row<uint8_t>(0), bytes), 0) << "left frame " << pairs;
    }
  }
  EXPECT_EQ(pairs, 228);
  EXPECT_EQ(good, 219);
}

TEST(FilesData, euroc_pairs_carry_the_time_in_their_names) {
  const auto mav = data / "euroc/mav0";
  NEEDS(mav);
  Config config;
  config.image_source.left = (mav / "cam0/data/*.png").string();
  config.image_source.right = (mav / "cam1/data/*.png").string();
  config.image_source.paramfile = mav.string();
  Player run(config);
  ASSERT_EQ(run.grab(), Outcome::valid);
  EXPECT_EQ(run.image(0).timestamp_ns, 1403715273262142976);
  int pairs = 1;
  while (run.grab() == Outcome::valid) ++pairs;
  EXPECT_EQ(pairs, 6);
}

TEST(FilesData, kitti_street_gives_41_pairs) {
  const auto set = data / "kitti_street";
  NEEDS(set);
  Config config;
  config.image_source.left = (set / "left/%06d.png").string();
  config.image_source.right = (set / "right/%06d.png").string();
  config.image_source.paramfile = (set / "calibration.yml").string();
  Player run(config);
  EXPECT_EQ(run.spec().width, 1226);
  int pairs = 0;
  while (run.grab() == Outcome::valid) ++pairs;
  EXPECT_EQ(pairs, 41);
}

/// Steps 40 to 44 of a daemon, the third one blind, 0.1 s from one to the next.
struct Replayed : Files {
  Config config;
  Replayed() {
    config.image_source.source = "files";
    config.image_source.recording = (folder_ / "drive").string();
  }
  void record(bool synthetic) {
    RecordingInfo info;
    info.width = 64, info.height = 48, info.synthetic = synthetic;
    RecordingWriter writer(folder_ / "drive", info);
    for (int i = 0; i < 5; ++i) {
      const cv::Mat left = picture(i, true), right = picture(i, false);
      RecordedStep step;
      step.sequence = static_cast<uint64_t>(40 + i);
      step.timestamp_ns = 1'000'000'000 + i * 100'000'000;
      step.flags = synthetic ? flag_synthetic : 0u;
      step.odometry.timestamp_ns = step.odometry.record.timestamp_ns = step.timestamp_ns - 1;
      step.odometry.record.frame = 2;
      if (i == 2) step.reason = Reason::no_camera;
      const RecordedViews views{left.data, right.data, static_cast<uint32_t>(left.step)};
      writer.add(step, step.has_pair() ? &views : nullptr);
    }
  }
};

TEST_F(Replayed, gives_pairs_blindness_times_and_numbers_as_they_were_and_begins_again) {
  record(false);
  config.image_source.loop = true;
  Player player(config);
  for (int round : {0, 1}) {
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(player.source().next_sequence(), static_cast<uint64_t>(40 + i + 5 * round));
      EXPECT_EQ(player.grab(), i == 2 ? Outcome::invalid : Outcome::valid);
      if (i == 2) {
        EXPECT_EQ(player.image(0).reason, Reason::no_camera);
      } else {
        EXPECT_EQ(player.value(0) - 100, 10 * i);
      }
      const int64_t time = 1'000'000'000 + (i + 5 * round) * 100'000'000;
      EXPECT_EQ(player.image(1).timestamp_ns, time);
      EXPECT_EQ(player.image(0).flags, flag_synthetic | flag_replayed) << "cameras saw it, and nobody drives by it";
      const RecordedStep& told = *player.source().recorded();
      EXPECT_EQ(told.odometry.timestamp_ns, time - 1);
      EXPECT_EQ(told.odometry.record.frame, 2u + 3 * static_cast<uint32_t>(round)) << "odometry begins anew where the recording does";
      EXPECT_EQ(told.odometry.flags, flag_synthetic | flag_replayed);
    }
  }
}

TEST_F(Replayed, what_was_synthetic_is_no_more_than_that) {
  record(true);
  Player player(config);
  player.grab();
  EXPECT_EQ(player.image(0).flags, static_cast<uint32_t>(flag_synthetic));
  EXPECT_EQ(player.grab(), Outcome::valid);
  EXPECT_EQ(player.grab(), Outcome::invalid);
  EXPECT_EQ(player.story(), "34.");
}

TEST_F(Replayed, without_inputs_pairs_are_counted_and_the_socket_may_tell) {
  record(true);
  std::filesystem::remove(folder_ / "drive/inputs.csv");
  Player player(config);
  EXPECT_EQ(player.source().recorded(), nullptr);
  EXPECT_EQ(player.source().next_sequence(), 0u);
  EXPECT_EQ(player.story(3), "013");
  EXPECT_EQ(player.image(0).timestamp_ns, 1'300'000'000);
  EXPECT_EQ(player.story(), "4.");
}

TEST_F(Replayed, a_picture_that_is_damaged_inside_makes_a_bad_pair_and_the_recording_goes_on) {
  record(true);
  std::fstream file(folder_ / "drive/left/1100000000_none.png", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(60);
  file << "damage";
  file.close();
  Player player(config);
  EXPECT_EQ(player.grab(), Outcome::valid);
  EXPECT_EQ(player.grab(), Outcome::invalid);
  EXPECT_EQ(player.image(0).reason, Reason::bad_pair);
  EXPECT_NE(player.source().fault().find("1100000000_none.png"), std::string_view::npos);
  EXPECT_EQ(player.grab(), Outcome::invalid);
  EXPECT_EQ(player.grab(), Outcome::valid);
  EXPECT_EQ(player.value(0) - 100, 30);
}

TEST_F(Replayed, other_sizes_and_recordings_without_a_pair_are_refused) {
  EXPECT_REFUSED(config, "66", "no such folder");
  record(true);
  config.image_source.width = 320;
  EXPECT_REFUSED(config, "78", "are 64x48, needed by width and height is 320x48");
  config.image_source.width = 0;
  std::filesystem::remove(folder_ / "drive/inputs.csv");
  std::ofstream(folder_ / "drive/index.csv") << "timestamp_ns,label,left,right,speed,turn_rate\n";
  EXPECT_REFUSED(config, "66", "holds no whole pair");
}

}  // namespace
}  // namespace vdisp
