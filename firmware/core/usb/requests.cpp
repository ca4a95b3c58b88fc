// What the device does with each control request.
#include "firmware/core/usb/device.hpp"
#include "firmware/core/usb/standard_requests.hpp"

namespace umov::firmware::usb {
namespace {

struct HidFunction {
  std::span<const std::uint8_t> hid;
  std::span<const std::uint8_t> report;
};

bool is_hid(std::uint16_t number) {
  return number == interface::reports || number == interface::hand;
}

HidFunction hid_function(std::uint16_t number) {
  if (number == interface::reports) {
    return {reports_hid_descriptor, reports_descriptor};
  }
  return {hand_hid_descriptor, hand_descriptor};
}

/// Length of the report that SET_REPORT is about, 0 when there is none of that kind.
std::size_t report_size(const Request& request) {
  const bool output = request.value_high() == hid::output_report;
  if (request.index == interface::hand) return output ? hand_report_bytes : 0;
  if (output) return report_bytes;
  return request.value_high() == hid::feature_report ? protocol::usb::presence_report_bytes : 0;
}

bool is_endpoint(std::uint16_t address) {
  return address == bulk_in || address == bulk_out || address == reports_in ||
         address == reports_out || address == hand_in;
}

std::uint16_t halt_bit(std::uint16_t address) {
  const auto endpoint = static_cast<EndpointAddress>(address);
  return static_cast<std::uint16_t>(1u << (endpoint_number(endpoint) + (is_in(endpoint) ? 8 : 0)));
}

}  // namespace

ControlAnswer Device::small_reply(std::size_t size) {
  return ControlAnswer::reply(std::span<const std::uint8_t>(small_).first(size));
}

bool Device::has_interface(const Request& request) const {
  return configuration_ != 0 && request.index < interface::count;
}

ControlAnswer Device::on_request(const Request& request) {
  switch (request.kind) {
    case RequestKind::standard:
      return on_standard(request);
    case RequestKind::class_specific:
      return on_class(request);
    case RequestKind::vendor:
      return on_vendor(request);
    case RequestKind::reserved:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer Device::on_standard(const Request& request) {
  if (!proper(request, asks_standard(request.number))) return ControlAnswer::refuse();
  const bool to_device = request.recipient == Recipient::device;
  const bool to_interface = request.recipient == Recipient::interface;
  switch (request.number) {
    case standard::get_status:
      return get_status(request);
    case standard::clear_feature:
      return change_halt(request, false);
    case standard::set_feature:
      return change_halt(request, true);
    case standard::set_address:
      if (!to_device || request.value > 127 || configuration_ != 0) break;
      port_->set_address(request.value_low());
      return ControlAnswer::accept();
    case standard::get_descriptor:
      return get_descriptor(request);
    case standard::get_configuration:
      if (!to_device) break;
      small_[0] = configuration_;
      return small_reply(1);
    case standard::set_configuration:
      if (!to_device || request.value > 1) break;
      set_configuration(request.value_low());
      return ControlAnswer::accept();
    case standard::get_interface:
      if (!to_interface || !has_interface(request)) break;
      small_[0] = 0;
      return small_reply(1);
    case standard::set_interface:
      // One setting each: choosing it starts its endpoints afresh.
      if (!to_interface || !has_interface(request) || request.value != 0) break;
      for (const EndpointAddress address : {bulk_in, bulk_out, reports_in, reports_out, hand_in}) {
        const bool bulk = endpoint_number(address) == endpoint_number(bulk_in);
        const bool hand = address == hand_in;
        const std::uint16_t owner = bulk   ? interface::bulk
                                    : hand ? interface::hand
                                           : interface::reports;
        if (owner != request.index) continue;
        Request clear = request;
        clear.recipient = Recipient::endpoint;
        clear.index = address;
        clear.value = standard::endpoint_halt;
        change_halt(clear, false);
      }
      return ControlAnswer::accept();
    default:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer Device::get_status(const Request& request) {
  constexpr std::uint8_t self_powered = 1;
  small_[0] = 0;
  small_[1] = 0;
  switch (request.recipient) {
    case Recipient::device:
      small_[0] = self_powered;
      return small_reply(2);
    case Recipient::interface:
      if (!has_interface(request)) break;
      return small_reply(2);
    case Recipient::endpoint:
      if (request.index == control_in || request.index == control_out) return small_reply(2);
      if (configuration_ == 0 || !is_endpoint(request.index)) break;
      small_[0] = (halted_ & halt_bit(request.index)) != 0 ? 1 : 0;
      return small_reply(2);
    case Recipient::other:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer Device::change_halt(const Request& request, bool halt) {
  // No remote wake-up and no test modes: the halt of an endpoint is the one feature.
  if (request.recipient != Recipient::endpoint || request.value != standard::endpoint_halt) {
    return ControlAnswer::refuse();
  }
  if (request.index == control_in || request.index == control_out) return ControlAnswer::accept();
  if (configuration_ == 0 || !is_endpoint(request.index)) return ControlAnswer::refuse();
  const auto address = static_cast<EndpointAddress>(request.index);
  if (halt) {
    halted_ |= halt_bit(address);
    port_->stall(address);
    links_.on_halt(address);
    return ControlAnswer::accept();
  }
  halted_ &= static_cast<std::uint16_t>(~halt_bit(address));
  port_->clear_stall(address);
  if (address == hand_in) {
    hand_sending_ = false;
    hand_told_ = false;
  } else {
    links_.on_halt_cleared(address);
  }
  return ControlAnswer::accept();
}

ControlAnswer Device::get_descriptor(const Request& request) const {
  const std::uint8_t type = request.value_high();
  if (request.recipient == Recipient::interface) {
    if (request.index == interface::dfu && type == dfu_functional_descriptor) {
      return ControlAnswer::reply(dfu_descriptor);
    }
    if (!is_hid(request.index) || request.value_low() != 0) return ControlAnswer::refuse();
    if (type == static_cast<std::uint8_t>(DescriptorType::hid)) {
      return ControlAnswer::reply(hid_function(request.index).hid);
    }
    if (type == static_cast<std::uint8_t>(DescriptorType::hid_report)) {
      return ControlAnswer::reply(hid_function(request.index).report);
    }
    return ControlAnswer::refuse();
  }
  return describe(descriptor_table, serial_, request);
}

ControlAnswer Device::on_class(const Request& request) {
  if (request.recipient != Recipient::interface || !has_interface(request)) {
    return ControlAnswer::refuse();
  }
  if (is_hid(request.index)) {
    switch (request.number) {
      case hid::set_report:
        if (request.to_host || request.length != report_size(request)) break;
        return ControlAnswer::take(room_);
      case hid::get_report:
        // Of the protocol's stream nothing may be read twice or out of turn; a state may.
        if (!request.to_host || request.value_high() != hid::input_report ||
            request.index != interface::hand)
          break;
        small_ = hand_state_bytes(application_->hand_state(hand_axis_));
        return small_reply(hand_report_bytes);
      case hid::set_idle:
        // Reports are sent when there is something to say, which is idle rate 0.
        if (!proper(request, false) || request.value_high() != 0) break;
        return ControlAnswer::accept();
      case hid::get_idle:
        if (!request.to_host) break;
        small_[0] = 0;
        return small_reply(1);
      default:
        break;
    }
    return ControlAnswer::refuse();
  }
  if (request.index == interface::dfu) {
    switch (request.number) {
      case dfu::detach:
        if (!proper(request, false) || !application_->detach_allowed()) break;
        detaching_ = true;
        return ControlAnswer::accept();
      case dfu::get_status:
        if (!request.to_host) break;
        small_ = {};
        small_[0] = dfu::status_ok;
        small_[4] = detaching_ ? dfu::state_app_detach : dfu::state_app_idle;
        return small_reply(6);
      case dfu::get_state:
        if (!request.to_host) break;
        small_[0] = detaching_ ? dfu::state_app_detach : dfu::state_app_idle;
        return small_reply(1);
      default:
        break;
    }
  }
  return ControlAnswer::refuse();
}

ControlAnswer Device::on_vendor(const Request& request) {
  if (request.recipient == Recipient::device && request.to_host &&
      request.number == ms_os_20::vendor_code && request.index == ms_os_20::descriptor_index) {
    return ControlAnswer::reply(windows_descriptors);
  }
  if (request.recipient == Recipient::interface && has_interface(request) &&
      request.index == interface::bulk && request.number == protocol::usb::request_user_present &&
      request.value <= 1 && proper(request, false)) {
    links_.on_user(PipeKind::bulk, request.value == 1);
    return ControlAnswer::accept();
  }
  return ControlAnswer::refuse();
}

bool Device::on_data(const Request& request, std::span<const std::uint8_t> data) {
  // SET_REPORT is the one request with data.
  if (request.index == interface::reports) {
    if (request.value_high() == hid::feature_report) {
      links_.on_user(PipeKind::reports, data[0] != 0);
    } else {
      links_.take_report(data);
    }
    return true;
  }
  if (data.size() != hand_report_bytes) return false;
  const HandReport report = parse_hand_report(data.first<hand_report_bytes>());
  if (report.axis >= protocol::axis_count) return false;
  hand_axis_ = report.axis;
  application_->on_hand_report(report);
  return true;
}

void Device::on_complete(const Request& request) {
  if (request.kind == RequestKind::class_specific && request.index == interface::dfu &&
      request.number == dfu::detach) {
    application_->on_detach();
  }
}

}  // namespace umov::firmware::usb
