// attach.h: what the words share: reaching the daemon, its topics, and being told to stop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ipc/include/vdisp/client.h"
#include "probe/words.h"

namespace vdisp {

/// Connects, waiting at most options.wait_s, and 2.5 s for a daemon that is there. Throws ProbeError: 64 no possible name, 69 no
/// daemon, 71 no shared memory, 77 no permission.
void attach(Client& client, const Options& options);

/// The daemon's topics. Throws ProbeError (69) where it does not tell them in time.
std::vector<CatalogueEntry> topics_of(Client& client);
/// Throws ProbeError (64), which lists the topics, where `topic` is none of them.
void require(const std::vector<CatalogueEntry>& topics, const std::string& topic);
/// Its name, also where the terminating zero is missing.
std::string_view name_of(const CatalogueEntry& entry);

/// From here on SIGINT, SIGTERM and SIGHUP end the word in good order: stopped() is then true, and waits are cut short.
void stop_on_signals();
bool stopped();

/// "fresh", "blind", "stale", "dead".
std::string_view name(Trust trust);
/// The state of a reading in one line: "BLIND: no calibration".
std::string state_words(const Reading& reading);

}  // namespace vdisp
