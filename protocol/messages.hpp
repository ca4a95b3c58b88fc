// All messages of the Umov protocol, each declared once.
//
// Conventions: integers only (native and ARM builds give the same bytes), little-endian, angles in
// microdegrees, times in microseconds of device time, lock-in sums in ADC codes x sine table.
// A request is answered by its `…_reply` or by `error_reply` carrying the request's sequence
// number.
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "protocol/field.hpp"

namespace umov::protocol {

inline constexpr std::uint16_t protocol_version = 1;

/// Order of the axes in every array of six.
enum class Axis : std::uint8_t { incidence, detector, azimuth, polarizer, analyzer, filter };
inline constexpr int axis_count = 6;

/// Analyser or polariser position that leaves the beam unpolarised ("open", U).
inline constexpr std::int32_t open_position = INT32_MIN;
/// Gain request: choose the range automatically.
inline constexpr std::uint8_t gain_auto = 0xff;
/// Laser request: all off.
inline constexpr std::uint8_t laser_none = 0;

using Name = std::array<char, 24>;  ///< UTF-8, padded with zeros

/// Reasons for the safe state. Latched until cleared, each reported once.
enum class Fault : std::uint8_t {
  none,
  interlock,
  emergency_stop,
  limit,
  stall,
  link_lost,
  watchdog,
  brown_out,
  adc_overrun,
  missed_deadline,
  not_homed,
  internal,
  settings_corrupt,
  over_temperature,
  rolled_back,
  no_fallback,
  reference_lost
};

/// What the controller is doing.
enum class State : std::uint8_t {
  idle,
  homing,
  moving,
  scanning,
  paused,
  waiting_for_rows,
  waiting_for_host,
  safe
};

/// Why a request was refused (error_reply.code).
enum class Refusal : std::uint8_t {
  none,
  unknown_message,
  bad_length,
  out_of_range,
  wrong_state,
  fault_active,
  not_homed,
  outside_limits,
  schema_mismatch,
  busy,
  stale_program,
  not_stored,
  no_reference
};

/// What the lock-in detects against.
enum class ReferenceSource : std::uint8_t {
  internal,  ///< the modulation output
  external   ///< rising edges at the reference input
};

/// What comes in at the reference input.
enum class ReferenceState : std::uint8_t {
  absent,        ///< no edges
  unsteady,      ///< edges whose period does not hold, or too few of them yet
  out_of_range,  ///< slower or faster than can be detected
  locked         ///< frequency and phase are known
};

struct Hello {
  std::uint16_t version{};
  std::uint64_t schema_hash{};
  Name host_name{};
  static constexpr MessageInfo info{0x01, "hello", Sender::host,
                                    "Opens a session. Flushes what an earlier, crashed host left "
                                    "in the pipe: the device answers only this."};
  static constexpr auto fields =
      std::tuple{field("version", &Hello::version, "1", "protocol version of the host"),
                 field("schema_hash", &Hello::schema_hash, "1",
                       "FNV-1a hash of all message declarations; must equal the device's"),
                 field("host_name", &Hello::host_name, "text",
                       "name of the host, shown to a second host that is refused")};
};

struct HelloReply {
  std::uint16_t version{};
  std::uint64_t schema_hash{};
  Name device_name{};
  Name serial{};
  std::uint64_t firmware_hash{};
  std::uint32_t boot_id{};
  std::uint32_t sample_rate_hz{};
  std::uint32_t adc_step_nv{};
  std::uint16_t adc_codes{};
  std::uint16_t sine_amplitude{};
  std::array<std::uint16_t, 4> gains{};
  std::array<std::uint16_t, 3> wavelengths_nm{};
  std::array<std::uint16_t, 6> filter_od_milli{};
  static constexpr MessageInfo info{0x81, "hello_reply", Sender::device,
                                    "Who the device is and the scales of its numbers."};
  static constexpr auto fields = std::tuple{
      field("version", &HelloReply::version, "1", "protocol version of the device"),
      field("schema_hash", &HelloReply::schema_hash, "1",
            "hash of the device's message declarations"),
      field("device_name", &HelloReply::device_name, "text", "board name"),
      field("serial", &HelloReply::serial, "text", "serial number"),
      field("firmware_hash", &HelloReply::firmware_hash, "1", "hash of the firmware build"),
      field("boot_id", &HelloReply::boot_id, "1", "changes at every start: device time began anew"),
      field("sample_rate_hz", &HelloReply::sample_rate_hz, "Hz", "ADC sample rate"),
      field("adc_step_nv", &HelloReply::adc_step_nv, "nV", "one ADC code at range 1"),
      field("adc_codes", &HelloReply::adc_codes, "1",
            "number of ADC codes; mid-scale is half of it"),
      field("sine_amplitude", &HelloReply::sine_amplitude, "1", "peak of the lock-in's sine table"),
      field("gains", &HelloReply::gains, "1", "nominal amplifier ranges"),
      field("wavelengths_nm", &HelloReply::wavelengths_nm, "nm", "lasers 1 to 3"),
      field("filter_od_milli", &HelloReply::filter_od_milli, "0.001",
            "optical density of filter positions 0 to 5")};
};

struct TimeSync {
  std::uint64_t host_time_us{};
  static constexpr MessageInfo info{0x02, "time_sync", Sender::host,
                                    "Asks for the device's clock."};
  static constexpr auto fields =
      std::tuple{field("host_time_us", &TimeSync::host_time_us, "us", "host clock when sent")};
};

struct TimeSyncReply {
  std::uint64_t host_time_us{};
  std::uint64_t received_us{};
  std::uint64_t sent_us{};
  static constexpr MessageInfo info{0x82, "time_sync_reply", Sender::device,
                                    "Device clock at reception and at reply."};
  static constexpr auto fields = std::tuple{
      field("host_time_us", &TimeSyncReply::host_time_us, "us", "echo of the request"),
      field("received_us", &TimeSyncReply::received_us, "us",
            "device clock when the request arrived"),
      field("sent_us", &TimeSyncReply::sent_us, "us", "device clock when the reply left")};
};

struct GetStatus {
  std::uint8_t reserved{};
  static constexpr MessageInfo info{0x03, "get_status", Sender::host,
                                    "Asks for the state; also serves as heartbeat."};
  static constexpr auto fields = std::tuple{field("reserved", &GetStatus::reserved, "1", "zero")};
};

struct Status {
  std::uint64_t time_us{};
  std::uint8_t state{};
  std::uint8_t fault{};
  std::uint8_t interlock_closed{};
  std::uint8_t homed_mask{};
  std::uint32_t program_id{};
  std::uint32_t row_count{};
  std::uint32_t next_row{};
  std::uint32_t first_unacknowledged{};
  std::uint32_t next_record{};
  std::array<std::int32_t, 6> position_udeg{};
  std::uint8_t reference_state{};
  std::uint32_t reference_mhz{};
  static constexpr MessageInfo info{0x83, "status", Sender::device,
                                    "State of the controller, the scan program and the axes."};
  static constexpr auto fields = std::tuple{
      field("time_us", &Status::time_us, "us", "device clock"),
      field("state", &Status::state, "enum State", "what the controller does"),
      field("fault", &Status::fault, "enum Fault", "latched fault, 0 = none"),
      field("interlock_closed", &Status::interlock_closed, "bool",
            "1 when the interlock allows the lasers"),
      field("homed_mask", &Status::homed_mask, "bits", "bit a: axis a has been homed"),
      field("program_id", &Status::program_id, "1", "program in memory, 0 = none"),
      field("row_count", &Status::row_count, "1", "rows of that program"),
      field("next_row", &Status::next_row, "1", "next row index the device wants to receive"),
      field("first_unacknowledged", &Status::first_unacknowledged, "1",
            "oldest record not yet acknowledged"),
      field("next_record", &Status::next_record, "1", "index of the next record to be measured"),
      field("position_udeg", &Status::position_udeg, "udeg", "axis positions"),
      field("reference_state", &Status::reference_state, "enum ReferenceState",
            "what comes in at the reference input, used or not"),
      field("reference_mhz", &Status::reference_mhz, "mHz",
            "frequency of the reference input while locked, else 0")};
};

struct GetAxis {
  std::uint8_t axis{};
  static constexpr MessageInfo info{0x04, "get_axis", Sender::host,
                                    "Asks for the properties of an axis."};
  static constexpr auto fields =
      std::tuple{field("axis", &GetAxis::axis, "enum Axis", "which axis", 0, axis_count - 1)};
};

struct AxisInfo {
  std::uint8_t axis{};
  std::uint32_t steps_per_turn{};
  std::int32_t min_udeg{};
  std::int32_t max_udeg{};
  std::uint32_t speed_mdeg_s{};
  std::uint32_t acceleration_mdeg_s2{};
  std::uint32_t jerk_mdeg_s3{};
  std::uint32_t take_up_udeg{};
  static constexpr MessageInfo info{0x84, "axis_info", Sender::device, "Properties of an axis."};
  static constexpr auto fields = std::tuple{
      field("axis", &AxisInfo::axis, "enum Axis", "which axis", 0, axis_count - 1),
      field("steps_per_turn", &AxisInfo::steps_per_turn, "1",
            "microsteps per 360 degrees of the axis"),
      field("min_udeg", &AxisInfo::min_udeg, "udeg", "lower soft limit"),
      field("max_udeg", &AxisInfo::max_udeg, "udeg", "upper soft limit"),
      field("speed_mdeg_s", &AxisInfo::speed_mdeg_s, "mdeg/s", "top speed"),
      field("acceleration_mdeg_s2", &AxisInfo::acceleration_mdeg_s2, "mdeg/s2", "top acceleration"),
      field("jerk_mdeg_s3", &AxisInfo::jerk_mdeg_s3, "mdeg/s3", "jerk"),
      field("take_up_udeg", &AxisInfo::take_up_udeg, "udeg",
            "overshoot that takes up backlash when arriving from above, 0 = off")};
};

struct SetAxis {
  std::uint8_t axis{};
  std::int32_t min_udeg{};
  std::int32_t max_udeg{};
  std::uint32_t speed_mdeg_s{};
  std::uint32_t acceleration_mdeg_s2{};
  std::uint32_t jerk_mdeg_s3{};
  std::uint32_t take_up_udeg{};
  static constexpr MessageInfo info{
      0x05, "set_axis", Sender::host,
      "Changes the properties of an axis (idle only). Answered by axis_info."};
  static constexpr auto fields =
      std::tuple{field("axis", &SetAxis::axis, "enum Axis", "which axis", 0, axis_count - 1),
                 field("min_udeg", &SetAxis::min_udeg, "udeg", "lower soft limit"),
                 field("max_udeg", &SetAxis::max_udeg, "udeg", "upper soft limit"),
                 field("speed_mdeg_s", &SetAxis::speed_mdeg_s, "mdeg/s", "top speed", 1, 720000),
                 field("acceleration_mdeg_s2", &SetAxis::acceleration_mdeg_s2, "mdeg/s2",
                       "top acceleration", 1, 100000000),
                 field("jerk_mdeg_s3", &SetAxis::jerk_mdeg_s3, "mdeg/s3", "jerk", 1, 2000000000),
                 field("take_up_udeg", &SetAxis::take_up_udeg, "udeg", "backlash take-up, 0 = off",
                       0, 10000000)};
};

struct SetLockin {
  std::uint32_t reference_mhz{};
  std::uint8_t harmonic{};
  std::int32_t phase_udeg{};
  std::uint16_t settle_ms{};
  std::uint8_t blocks{};
  std::uint8_t source{};
  static constexpr MessageInfo info{0x06, "set_lockin", Sender::host,
                                    "Sets modulation and detection (idle only)."};
  static constexpr auto fields = std::tuple{
      field("reference_mhz", &SetLockin::reference_mhz, "mHz",
            "modulation frequency; of no effect with an external reference", 10000, 20000000),
      field("harmonic", &SetLockin::harmonic, "1", "harmonic detected", 1, 9),
      field("phase_udeg", &SetLockin::phase_udeg, "udeg", "added to the reference phase",
            -180000000, 180000000),
      field("settle_ms", &SetLockin::settle_ms, "ms",
            "wait after moves and gain changes before integrating", 0, 10000),
      field("blocks", &SetLockin::blocks, "1", "blocks per record for the standard error", 2, 64),
      field("source", &SetLockin::source, "enum ReferenceSource",
            "what is detected against; external: the modulation output stays on while sampling", 0,
            1)};
};

struct GetLockin {
  std::uint8_t reserved{};
  static constexpr MessageInfo info{0x07, "get_lockin", Sender::host,
                                    "Asks for the modulation and detection in force."};
  static constexpr auto fields = std::tuple{field("reserved", &GetLockin::reserved, "1", "zero")};
};

struct LockinInfo {
  std::uint32_t reference_mhz{};
  std::uint8_t harmonic{};
  std::int32_t phase_udeg{};
  std::uint16_t settle_ms{};
  std::uint8_t blocks{};
  std::uint8_t source{};
  static constexpr MessageInfo info{0x87, "lockin_info", Sender::device,
                                    "Modulation and detection, as in set_lockin."};
  static constexpr auto fields = std::tuple{
      field("reference_mhz", &LockinInfo::reference_mhz, "mHz", "modulation frequency asked for"),
      field("harmonic", &LockinInfo::harmonic, "1", "harmonic detected"),
      field("phase_udeg", &LockinInfo::phase_udeg, "udeg", "added to the reference phase"),
      field("settle_ms", &LockinInfo::settle_ms, "ms",
            "wait after moves and gain changes before integrating"),
      field("blocks", &LockinInfo::blocks, "1", "blocks per record for the standard error"),
      field("source", &LockinInfo::source, "enum ReferenceSource", "what is detected against")};
};

struct SaveSettings {
  std::uint8_t action{};
  static constexpr MessageInfo info{
      0x08, "save_settings", Sender::host,
      "Keeps the settings in force (all axes, modulation and detection) over restarts (idle only). "
      "A power cut meanwhile leaves those saved before."};
  static constexpr auto fields = std::tuple{
      field("action", &SaveSettings::action, "1",
            "0 save those in force, 1 go back to the built-in ones and save these", 0, 1)};
};

struct ProgramBegin {
  std::uint32_t program_id{};
  std::uint32_t first_row{};
  std::uint32_t row_count{};
  static constexpr MessageInfo info{0x10, "program_begin", Sender::host,
                                    "Starts a scan program. The device then asks for rows by "
                                    "`row_credit` and measures them in order."};
  static constexpr auto fields = std::tuple{
      field("program_id", &ProgramBegin::program_id, "1", "hash of the plan, not 0", 1, UINT32_MAX),
      field("first_row", &ProgramBegin::first_row, "1",
            "first row to be measured (a resumed scan starts late)"),
      field("row_count", &ProgramBegin::row_count, "1", "rows of the whole program", 1,
            UINT32_MAX)};
};

struct ProgramRow {
  std::uint32_t index{};
  std::array<std::int32_t, 6> target_udeg{};
  std::uint8_t laser{};
  std::uint8_t shutter_open{};
  std::uint8_t gain{};
  std::uint16_t dwell_ms{};
  static constexpr MessageInfo info{
      0x11, "program_row", Sender::host,
      "One row of the program. Rows out of order or already held are ignored, not errors."};
  static constexpr auto fields =
      std::tuple{field("index", &ProgramRow::index, "1", "row index"),
                 field("target_udeg", &ProgramRow::target_udeg, "udeg",
                       "commanded axis positions; polariser or analyser INT32_MIN = open"),
                 field("laser", &ProgramRow::laser, "1", "laser 1 to 3, 0 = none", 0, 3),
                 field("shutter_open", &ProgramRow::shutter_open, "bool", "shutter", 0, 1),
                 field("gain", &ProgramRow::gain, "1", "amplifier range 0 to 3, 255 = auto"),
                 field("dwell_ms", &ProgramRow::dwell_ms, "ms",
                       "integration time, rounded to whole reference periods", 1, 60000)};
};

struct RowCredit {
  std::uint32_t program_id{};
  std::uint32_t next_row{};
  std::uint16_t free_slots{};
  static constexpr MessageInfo info{0x91, "row_credit", Sender::device,
                                    "Acknowledges rows below next_row and says how many more fit."};
  static constexpr auto fields =
      std::tuple{field("program_id", &RowCredit::program_id, "1", "program"),
                 field("next_row", &RowCredit::next_row, "1", "next row wanted"),
                 field("free_slots", &RowCredit::free_slots, "1", "rows that fit from there on")};
};

struct ProgramControl {
  std::uint8_t action{};
  static constexpr MessageInfo info{0x12, "program_control", Sender::host,
                                    "Pauses, resumes or ends the program."};
  static constexpr auto fields =
      std::tuple{field("action", &ProgramControl::action, "1",
                       "0 pause, 1 resume, 2 abort (unacknowledged records are kept)", 0, 2)};
};

struct Record {
  std::uint32_t program_id{};
  std::uint32_t index{};
  std::uint64_t time_us{};
  std::array<std::int32_t, 6> position_steps{};
  std::uint8_t laser{};
  std::uint8_t shutter_open{};
  std::uint8_t gain{};
  std::int8_t direction{};
  std::uint32_t samples{};
  std::uint32_t saturated{};
  std::int64_t signal_x{};
  std::int64_t signal_y{};
  std::int64_t monitor_x{};
  std::int64_t monitor_y{};
  std::uint64_t signal_x_se{};
  std::uint64_t signal_y_se{};
  std::uint64_t monitor_se{};
  static constexpr MessageInfo info{
      0x20, "record", Sender::device,
      "One lock-in record. Stays in the device's ring until acknowledged; may be sent again."};
  static constexpr auto fields = std::tuple{
      field("program_id", &Record::program_id, "1", "program"),
      field("index", &Record::index, "1", "row index"),
      field("time_us", &Record::time_us, "us", "device time at the centre of integration"),
      field("position_steps", &Record::position_steps, "steps", "step counters during integration"),
      field("laser", &Record::laser, "1", "laser 1 to 3, 0 = none", 0, 3),
      field("shutter_open", &Record::shutter_open, "bool", "shutter", 0, 1),
      field("gain", &Record::gain, "1", "amplifier range used, 0 to 3", 0, 3),
      field("direction", &Record::direction, "1",
            "sense of the last detector-arm move that was not zero", -1, 1),
      field("samples", &Record::samples, "1",
            "ADC samples integrated, a whole number of reference periods (of an external "
            "reference to the nearest sample, sums scaled to it)"),
      field("saturated", &Record::saturated, "1", "clipped ADC samples, signal or monitor"),
      field("signal_x", &Record::signal_x, "code*sine", "sum of signal x in-phase reference"),
      field("signal_y", &Record::signal_y, "code*sine", "sum of signal x quadrature reference"),
      field("monitor_x", &Record::monitor_x, "code*sine", "sum of monitor x in-phase reference"),
      field("monitor_y", &Record::monitor_y, "code*sine", "sum of monitor x quadrature reference"),
      field("signal_x_se", &Record::signal_x_se, "code*sine",
            "standard error of signal_x from block scatter"),
      field("signal_y_se", &Record::signal_y_se, "code*sine", "standard error of signal_y"),
      field("monitor_se", &Record::monitor_se, "code*sine", "standard error of monitor_x")};
};

struct RecordAck {
  std::uint32_t program_id{};
  std::uint32_t next_index{};
  static constexpr MessageInfo info{
      0x21, "record_ack", Sender::host,
      "All records below next_index are safe on disk; the device may forget them."};
  static constexpr auto fields =
      std::tuple{field("program_id", &RecordAck::program_id, "1", "program"),
                 field("next_index", &RecordAck::next_index, "1", "first record not yet safe")};
};

struct Home {
  std::uint8_t axis_mask{};
  static constexpr MessageInfo info{
      0x30, "home", Sender::host,
      "Homes the axes of the mask, one after the other. Refused while a fault is latched."};
  static constexpr auto fields =
      std::tuple{field("axis_mask", &Home::axis_mask, "bits", "bit a: axis a", 1, 63)};
};

struct Move {
  std::uint8_t axis{};
  std::int32_t target_udeg{};
  static constexpr MessageInfo info{
      0x31, "move", Sender::host,
      "Moves one axis (idle only). Refused while a fault is latched or the axis is not homed."};
  static constexpr auto fields =
      std::tuple{field("axis", &Move::axis, "enum Axis", "which axis", 0, axis_count - 1),
                 field("target_udeg", &Move::target_udeg, "udeg",
                       "target; polariser or analyser INT32_MIN = open")};
};

struct Stop {
  std::uint8_t emergency{};
  static constexpr MessageInfo info{0x32, "stop", Sender::host,
                                    "Stops all motion with controlled deceleration; emergency also "
                                    "latches the fault emergency_stop."};
  static constexpr auto fields =
      std::tuple{field("emergency", &Stop::emergency, "bool", "1 = safe state", 0, 1)};
};

struct ClearFault {
  std::uint8_t fault{};
  static constexpr MessageInfo info{
      0x33, "clear_fault", Sender::host,
      "Clears the latched fault named; refused while its cause persists."};
  static constexpr auto fields =
      std::tuple{field("fault", &ClearFault::fault, "enum Fault", "fault to clear", 1, 16)};
};

struct FaultEvent {
  std::uint64_t time_us{};
  std::uint8_t fault{};
  std::int32_t detail{};
  static constexpr MessageInfo info{0xb3, "fault_event", Sender::device,
                                    "A fault was latched; sent once."};
  static constexpr auto fields = std::tuple{
      field("time_us", &FaultEvent::time_us, "us", "device time"),
      field("fault", &FaultEvent::fault, "enum Fault", "which"),
      field("detail", &FaultEvent::detail, "1",
            "axis or row it concerns, -1 = none; of reference_lost: enum ReferenceState, what came "
            "in; of rolled_back, no_fallback and internal: boot_note.hpp")};
};

struct ReadLog {
  std::uint16_t index{};
  static constexpr MessageInfo info{0x34, "read_log", Sender::host,
                                    "Asks for an entry of the persistent fault log, 0 = newest."};
  static constexpr auto fields = std::tuple{field("index", &ReadLog::index, "1", "entry")};
};

struct LogEntry {
  std::uint16_t index{};
  std::uint16_t count{};
  std::uint64_t time_us{};
  std::uint32_t boot_id{};
  std::uint8_t fault{};
  std::int32_t detail{};
  static constexpr MessageInfo info{0xb4, "log_entry", Sender::device,
                                    "An entry of the fault log; fault 0 = no such entry."};
  static constexpr auto fields = std::tuple{
      field("index", &LogEntry::index, "1", "entry"),
      field("count", &LogEntry::count, "1", "entries in the log"),
      field("time_us", &LogEntry::time_us, "us", "device time of that boot"),
      field("boot_id", &LogEntry::boot_id, "1", "boot it happened in"),
      field("fault", &LogEntry::fault, "enum Fault", "which"),
      field("detail", &LogEntry::detail, "1",
            "axis or row it concerns, -1 = none; of reference_lost: enum ReferenceState, what came "
            "in; of rolled_back, no_fallback and internal: boot_note.hpp")};
};

struct Busy {
  Name owner{};
  static constexpr MessageInfo info{
      0xfd, "busy", Sender::device,
      "Another host holds the session: answers a hello on a pipe that serves one host at a time."};
  static constexpr auto fields =
      std::tuple{field("owner", &Busy::owner, "text",
                       "host_name of the host that holds the session, empty if unknown")};
};

struct Done {
  std::uint8_t request{};
  static constexpr MessageInfo info{
      0xfe, "done", Sender::device,
      "Accepts a request that has no reply of its own; carries the request's sequence number."};
  static constexpr auto fields =
      std::tuple{field("request", &Done::request, "1", "type of the request")};
};

struct ErrorReply {
  std::uint8_t request{};
  std::uint8_t code{};
  std::int32_t detail{};
  static constexpr MessageInfo info{0xff, "error_reply", Sender::device,
                                    "Refuses a request; carries the request's sequence number."};
  static constexpr auto fields = std::tuple{
      field("request", &ErrorReply::request, "1", "type of the request"),
      field("code", &ErrorReply::code, "enum Refusal", "why"),
      field("detail", &ErrorReply::detail, "1", "axis or field number it concerns, -1 = none")};
};

/// Every message, in the order of PROTOCOL.md.
using AllMessages =
    std::tuple<Hello, HelloReply, TimeSync, TimeSyncReply, GetStatus, Status, GetAxis, AxisInfo,
               SetAxis, SetLockin, GetLockin, LockinInfo, SaveSettings, ProgramBegin, ProgramRow,
               RowCredit, ProgramControl, Record, RecordAck, Home, Move, Stop, ClearFault,
               FaultEvent, ReadLog, LogEntry, Busy, Done, ErrorReply>;

}  // namespace umov::protocol
