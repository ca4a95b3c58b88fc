// What is thrown when a controller stops answering.
#pragma once

#include <string>

#include "host/errors/error.hpp"

namespace umov::instrument {

/// The pipe broke, or the controller is silent on it. The instrument may be fine: connect again,
/// open a new Session and go on; ProgramStream loses no record over it.
class LinkLost : public Error {
 public:
  /// `device` is Transport::name(); the message is about that place.
  LinkLost(const std::string& device, std::string problem)
      : Error(Place{device}, std::move(problem),
              "check cable and power, then repeat the command; a scan goes on with --resume") {}
};

/// A request that must not be repeated blindly got no answer: whether it was carried out is
/// unknown. Session::request(GetStatus{}) tells.
class Unanswered : public Error {
 public:
  Unanswered(const std::string& device, std::string problem)
      : Error(Place{device}, std::move(problem),
              "ask for the status (umov device info) before repeating it") {}
};

}  // namespace umov::instrument
