// reload.cpp: three configurations, row by row.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/reload.h"

namespace vdisp {

Reload merge(const Config& before, const Config& now, Config& running, Precedence precedence) {
  Reload reload;
  Config merged = running;
  for (const Parameter& row : parameters()) {
    if (row.key == "angRot" && row.section == "Map") continue;  // the same value as in [Limit obstacle]
    const std::string wanted = row.get(now), used = row.get(running);
    if (wanted == used) continue;
    if (row.when == When::restart) {
      reload.restart.push_back(&row);
    } else if (precedence == Precedence::hand && wanted == row.get(before)) {
      reload.kept.push_back(&row);
    } else {
      reload.taken.push_back(&row);
      row.set(merged, wanted);
    }
  }
  const std::vector<Contradiction> contradictions = check(merged);
  if (!contradictions.empty()) {
    reload.fault =
        "with what " + std::string(reload.restart.empty() ? "was set by hand" : "needs a restart") + " as it is: " + contradictions[0].text;
    return reload;
  }
  running = std::move(merged);
  return reload;
}

}  // namespace vdisp
