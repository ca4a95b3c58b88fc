// Whoever stands at the instrument: asked to change the set-up between parts of a scan.
#pragma once

#include <functional>

#include "host/scan/arrangement.hpp"

namespace umov::cli {

/// Says on stderr what to do and waits for Enter on stdin; Ctrl-C calls the scan off. What is to be
/// undone after the last rows is said, but not waited for. `before` ends the progress line. Throws
/// umov::Error where stdin ends instead.
scan::Arranger ask_operator(std::function<void()> before);

/// Whether there is someone to ask: stdin and stderr are a terminal.
bool operator_at_terminal();

}  // namespace umov::cli
