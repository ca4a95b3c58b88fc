#include "host/instrument/program_control.hpp"

#include "host/instrument/link_lost.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::instrument {

using protocol::State;

void control_program(Session& session, ProgramAction action) {
  try {
    session.request(protocol::ProgramControl{static_cast<std::uint8_t>(action)});
  } catch (const Unanswered&) {
  } catch (const Refused& refused) {
    if (refused.refusal() != protocol::Refusal::wrong_state) throw;
  }
}

bool is_running(const protocol::Status& status) {
  const auto state = static_cast<State>(status.state);
  return state == State::scanning || state == State::paused || state == State::waiting_for_rows ||
         state == State::waiting_for_host;
}

bool is_idle(const protocol::Status& status) {
  return static_cast<State>(status.state) == State::idle;
}

}  // namespace umov::instrument
