// Settings kept over restarts: taken over at the start, saved and set back by command.
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/config/saved_settings.hpp"
#include "firmware/core/controller.hpp"

namespace umov::firmware {

using protocol::Fault;
using protocol::Refusal;

bool Controller::lockin_allowed(const protocol::SetLockin& lockin) {
  // What comes in from outside is judged when it is there.
  constexpr auto external = static_cast<std::uint8_t>(protocol::ReferenceSource::external);
  return lockin.source == external || detectable(lockin.reference_mhz, lockin.harmonic);
}

SavedSettings Controller::settings_in_force() const {
  SavedSettings all{.axes = {}, .lockin = sequencer_.settings()};
  for (std::size_t i = 0; i < all.axes.size(); ++i) {
    const AxisSettings& s = motion_.settings(static_cast<int>(i));
    all.axes[i] = {static_cast<std::uint8_t>(i), s.min_udeg,     s.max_udeg,    s.speed_mdeg_s,
                   s.acceleration_mdeg_s2,       s.jerk_mdeg_s3, s.take_up_udeg};
  }
  return all;
}

bool Controller::take_over(const SavedSettings& settings) {
  if (!lockin_allowed(settings.lockin)) return false;
  for (const auto& axis : settings.axes) {
    if (!motion_.change_settings(axis)) return false;
  }
  sequencer_.configure(settings.lockin);
  return true;
}

void Controller::load_settings() {
  built_in_ = settings_in_force();
  if (settings_ == nullptr) return;
  // Told with the fault: what was wrong.
  constexpr std::int32_t damaged = 0, other_layout = 1, refused = 2;
  SettingsBytes bytes{};
  switch (settings_->load(settings_layout, bytes)) {
    case SettingsStore::Loaded::none:
      return;
    case SettingsStore::Loaded::damaged:
      return raise(Fault::settings_corrupt, damaged);
    case SettingsStore::Loaded::other_layout:
      return raise(Fault::settings_corrupt, other_layout);
    case SettingsStore::Loaded::good:
      break;
  }
  SavedSettings saved;
  if (settings_from_bytes(bytes, saved) && take_over(saved)) return;
  take_over(built_in_);
  raise(Fault::settings_corrupt, refused);
}

void Controller::handle(const FrameView& frame, const protocol::GetLockin&) {
  const protocol::SetLockin& now = sequencer_.settings();
  link_.reply(frame.sequence, protocol::LockinInfo{now.reference_mhz, now.harmonic, now.phase_udeg,
                                                   now.settle_ms, now.blocks, now.source});
}

void Controller::handle(const FrameView& frame, const protocol::SaveSettings& message) {
  if (sequencer_.active() || motion_.busy()) return refuse(frame, Refusal::wrong_state);
  constexpr std::uint8_t back_to_built_in = 1;
  const bool back = message.action == back_to_built_in;
  const SettingsBytes bytes = settings_to_bytes(back ? built_in_ : settings_in_force());
  if (settings_ == nullptr || board_->supply_low()) return refuse(frame, Refusal::not_stored);
  // The next tick comes late then: it is dark, and nothing moves.
  if (settings_->next_save_is_slow()) ticked_ = false;
  if (!settings_->save(settings_layout, bytes)) return refuse(frame, Refusal::not_stored);
  if (back) take_over(built_in_);
  accept(frame);
}

}  // namespace umov::firmware
