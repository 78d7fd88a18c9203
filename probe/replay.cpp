// replay.cpp: vdisp-probe replay: becomes vdispd with the recording as its source.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "ipc/recording.h"
#include "probe/config_text.h"
#include "probe/daemon_program.h"
#include "probe/words.h"

namespace vdisp {

int replay(const Options& options) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::absolute(options.output, error);
  std::vector<std::string> words{daemon_program()};
  try {
    const Recording recording(folder);
    if (!recording.configuration().empty()) words.insert(words.end(), {"-c", recording.configuration().string()});
  } catch (const RecordingError& broken) {
    throw ProbeError(RecordingError::exit_code, broken.what());
  }
  // Of the run that was recorded, not of this one: its source, its socket, its flight recorder, and what it had of its machine.
  for (const char* set : {"image source.source=files", "image source.left=", "image source.right=", "image source.odometry=",
                          "image source.paramfile=", "image source.width=0", "image source.height=0", "image source.rate=0",
                          "image source.loop=no", "control.socket=", "ipc.group=", "recorder.seconds=0",
                          "main.metrics=", "main.scheduling=other", "main.cpus=", "main.lockMemory=no", "main.period=0"})
    words.insert(words.end(), {"--set", set});
  words.insert(words.end(), {"--set", "image source.recording=" + in_quotes(folder.string())});
  words.insert(words.end(), options.topics.begin(), options.topics.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  throw ProbeError(69, words[0] + ": cannot be started: " + std::strerror(errno) + "; it is installed beside vdisp-probe, or on the PATH");
}

}  // namespace vdisp
