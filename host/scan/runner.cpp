#include "host/scan/runner.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/errors/error.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/program_stream.hpp"
#include "host/instrument/refusals.hpp"
#include "host/instrument/session.hpp"
#include "host/scan/record_scale.hpp"

namespace umov::scan {
namespace {

using instrument::LinkLost;
using instrument::ProgramStream;
using instrument::Session;

constexpr std::uint8_t all_axes = 0x3f;

/// The clock of a scan: which boot of the controller it began in and when.
struct TimeBase {
  std::uint32_t boot_id = 0;
  double start_us = 0;
};

std::string name_text(const protocol::Name& name) {
  const std::string text(name.begin(), name.end());
  return text.substr(0, text.find('\0'));
}

std::int32_t microdegrees(double deg) {
  return std::isnan(deg) ? protocol::open_position
                         : static_cast<std::int32_t>(std::lround(1e6 * deg));
}

int gain_range(const protocol::HelloReply& device, int gain) {
  for (std::size_t i = 0; i < device.gains.size(); ++i) {
    if (device.gains[i] == gain) return static_cast<int>(i);
  }
  throw Error(fmt::format("the controller has no amplifier range {}", gain),
              fmt::format("use gain = \"auto\" or one of {}, {}, {}, {}", device.gains[0],
                          device.gains[1], device.gains[2], device.gains[3]));
}

std::uint8_t laser_of(const protocol::HelloReply& device, double wavelength_nm) {
  for (std::size_t i = 0; i < device.wavelengths_nm.size(); ++i) {
    if (device.wavelengths_nm[i] == wavelength_nm) return static_cast<std::uint8_t>(i + 1);
  }
  throw Error(fmt::format("the instrument has no laser of {:g} nm", wavelength_nm),
              fmt::format("use wavelengths_nm out of {}, {}, {}", device.wavelengths_nm[0],
                          device.wavelengths_nm[1], device.wavelengths_nm[2]));
}

std::int32_t filter_position_udeg(const protocol::HelloReply& device, double optical_density) {
  for (std::size_t i = 0; i < device.filter_od_milli.size(); ++i) {
    if (device.filter_od_milli[i] == std::lround(1000 * optical_density)) {
      return static_cast<std::int32_t>(i) * 60'000'000;
    }
  }
  throw Error(fmt::format("the filter wheel has no optical density {:g}", optical_density),
              "use one of the densities that `umov device info` lists");
}

/// A plan's row in the units of the controller.
protocol::ProgramRow to_device(const PlanRow& row, std::uint32_t index,
                               const protocol::HelloReply& device) {
  protocol::ProgramRow out;
  out.index = index;
  out.target_udeg = {
      microdegrees(row.theta_i_deg),  microdegrees(row.theta_r_deg),
      microdegrees(row.phi_r_deg),    microdegrees(row.polarizer_deg),
      microdegrees(row.analyzer_deg), filter_position_udeg(device, row.optical_density)};
  out.laser = laser_of(device, row.wavelength_nm);
  out.shutter_open = row.shutter_open ? 1 : 0;
  out.gain = row.gain == gain_auto ? protocol::gain_auto
                                   : static_cast<std::uint8_t>(gain_range(device, row.gain));
  out.dwell_ms = static_cast<std::uint16_t>(row.dwell_ms);
  return out;
}

/// Records on their way to the journal.
class JournalSink : public instrument::RecordSink {
 public:
  JournalSink(formats::JournalWriter& journal, const std::vector<PlanRow>& rows)
      : journal_(&journal), rows_(&rows) {}

  void connect(const protocol::HelloReply& device, double start_us) {
    device_ = device;
    start_us_ = start_us;
  }
  void take(const protocol::Record& record) override {
    pending_.push_back(scaled(record, rows_->at(record.index), device_, start_us_));
    last_time_s_ = pending_.back().time_s;
  }
  void secure() override {
    journal_->append(pending_);
    journal_->sync();
    pending_.clear();
  }
  double last_time_s() const { return last_time_s_; }
  void set_last_time_s(double time_s) { last_time_s_ = time_s; }

 private:
  formats::JournalWriter* journal_;
  const std::vector<PlanRow>* rows_;
  protocol::HelloReply device_{};
  double start_us_ = 0;
  double last_time_s_ = 0;
  std::vector<formats::ScanRecord> pending_;
};

std::string settings_text(const TimeBase& base, const Plan& plan,
                          const protocol::HelloReply& device) {
  return nlohmann::json{{"boot_id", base.boot_id},
                        {"start_us", base.start_us},
                        {"reference_hz", plan.reference_hz},
                        {"settle_ms", plan.settle_ms},
                        {"sample_rate_hz", device.sample_rate_hz},
                        {"sine_amplitude", device.sine_amplitude}}
      .dump();
}

TimeBase time_base_of(const formats::Provenance& provenance) {
  const auto json = nlohmann::json::parse(provenance.settings, nullptr, false);
  if (json.is_discarded() || !json.contains("boot_id") || !json.contains("start_us")) return {};
  return {json["boot_id"].get<std::uint32_t>(), json["start_us"].get<double>()};
}

formats::JournalHeader header_for(const Plan& plan, const Program& program,
                                  const RunOptions& options, const Session& session,
                                  const TimeBase& base) {
  const auto& device = session.device();
  const double adc_step_v = 1e-9 * device.adc_step_nv;
  formats::JournalHeader header;
  header.program_id = program_id(plan);
  header.row_count = program.rows.size();
  header.blocks = program.blocks;
  header.keys = header_keys(plan);
  const auto set = [&](const std::string& key, const std::string& value) {
    for (auto& [name, old] : header.keys) {
      if (name == key) {
        old = value;
        return;
      }
    }
    header.keys.emplace_back(key, value);
  };
  set("device", fmt::format("{} {}", name_text(device.device_name), name_text(device.serial)));
  set("adc_step_v", fmt::format("{:.6g}", adc_step_v));
  set("adc_full_scale_v", fmt::format("{:.6g}", adc_step_v * device.adc_codes / 2));
  header.provenance.program = options.program;
  header.provenance.command = options.command;
  header.provenance.created = formats::utc_now();
  header.provenance.device = fmt::format("{} {} at {}", name_text(device.device_name),
                                         name_text(device.serial), session.name());
  header.provenance.firmware_hash = fmt::format("{:016x}", device.firmware_hash);
  header.provenance.role = plan.role;
  header.provenance.plan = plan.text;
  header.provenance.settings = settings_text(base, plan, device);
  return header;
}

/// One scan from first connection to finished file.
class Runner {
 public:
  Runner(const Plan& plan, const RunOptions& options)
      : plan_(plan), options_(options), program_(expand(plan)), id_(program_id(plan)) {
    summary_.total = static_cast<std::uint32_t>(program_.rows.size());
  }

  RunSummary run() {
    refuse_changes_by_hand();
    open_existing();
    if (next_ < summary_.total) {
      measure();
    } else {
      summary_.complete = true;
    }
    finish_file();
    return summary_;
  }

 private:
  /// Rows that need someone at the instrument can't be taken in one unattended run.
  void refuse_changes_by_hand() const {
    for (const auto& block : program_.blocks) {
      for (const auto& [key, value] : block.settings) {
        if (key == "optical_density") continue;  // the filter wheel does it
        throw Error(
            {plan_.name},
            fmt::format(
                "block {} needs a change at the instrument ({}={}) that the controller can't make",
                block.name, key, value),
            "leave it out of this plan and measure it as a scan of its own after the change");
      }
    }
  }

  void open_existing() {
    const auto journal = journal_path(options_.output);
    const bool has_journal = std::filesystem::exists(journal);
    const bool has_output = std::filesystem::exists(options_.output);
    if (options_.resume) {
      if (!has_journal) {
        throw Error({options_.output.string()},
                    has_output ? "this scan is complete; there is nothing to resume"
                               : "there is no scan to resume",
                    has_output ? "measure again with --force" : "start it without --resume");
      }
      formats::Journal found;
      writer_ = formats::JournalWriter::resume(journal, found);
      if (found.header.program_id != id_) {
        throw Error({journal.string()}, "the unfinished scan was made with another plan",
                    "resume with that plan, or start over with --force");
      }
      base_ = time_base_of(found.header.provenance);
      next_ = static_cast<std::uint32_t>(found.next_index());
      summary_.resumed_from = next_;
      if (!found.records.empty()) last_time_s_ = found.records.back().time_s;
      return;
    }
    if (!options_.overwrite && has_journal) {
      throw Error({journal.string()}, "an unfinished scan is there",
                  "finish it with --resume, or start over with --force");
    }
    if (!options_.overwrite && has_output) {
      throw Error({options_.output.string()}, "the file exists",
                  "choose another name, or use --force");
    }
  }

  void measure() {
    std::optional<ProgramStream> stream;
    std::optional<JournalSink> sink;
    protocol::HelloReply device;
    int tries_left = options_.reconnects;
    auto wait = options_.reconnect_wait;
    for (;;) {
      try {
        Session session(connect(stream.has_value()));
        device = session.device();
        if (!stream) check_against_device(session);
        prepare(session);
        if (stream) {
          ++summary_.lost_links;
        } else {
          start_journal(session);
          sink.emplace(*writer_, program_.rows);
          sink->set_last_time_s(last_time_s_);
          stream.emplace(
              instrument::ProgramOptions{
                  .program_id = id_, .row_count = summary_.total, .first_missing = next_},
              [&](std::uint32_t index) {
                return to_device(program_.rows.at(index), index, device);
              },
              *sink);
        }
        rebase(session, sink->last_time_s());
        sink->connect(device, base_.start_us);
        const auto before = stream->next_index();
        summary_.complete = stream->run(session, [&](const ProgramStream& now) {
          if (now.next_index() > before) {
            tries_left = options_.reconnects;
            wait = options_.reconnect_wait;
          }
          report(now.next_index());
          return wanted();
        });
        return;
      } catch (const LinkLost&) {
        if (!stream || tries_left-- == 0 || !wanted()) {
          finish_file();
          throw;
        }
      } catch (const Error&) {
        finish_file();
        throw;
      }
      if (options_.progress) options_.progress({next_, summary_.total, "link lost, trying again"});
      std::this_thread::sleep_for(wait);
      wait *= 2;
    }
  }

  /// Refuses a plan that this instrument can't do before anything moves or is written.
  void check_against_device(Session& session) {
    std::array<protocol::AxisInfo, protocol::axis_count> axes;
    for (std::uint8_t axis = 0; axis < protocol::axis_count; ++axis) {
      axes[axis] = session.request(protocol::GetAxis{axis});
    }
    for (std::uint32_t index = 0; index < summary_.total; ++index) {
      const auto row = to_device(program_.rows[index], index, session.device());
      for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const auto target = row.target_udeg[axis];
        if (target == protocol::open_position) continue;
        if (target >= axes[axis].min_udeg && target <= axes[axis].max_udeg) continue;
        throw Error(
            {plan_.name},
            fmt::format("row {} asks the {} axis for {:g} degrees; its limits are {:g} to {:g}",
                        index, instrument::axis_name(static_cast<int>(axis)), 1e-6 * target,
                        1e-6 * axes[axis].min_udeg, 1e-6 * axes[axis].max_udeg),
            "change the plan, or the axis' limits with umov device config");
      }
    }
  }

  /// While a lost link is taken up again, a controller that can't be reached is still a lost link.
  std::unique_ptr<instrument::Transport> connect(bool again) {
    if (!again) return options_.connect();
    try {
      return options_.connect();
    } catch (const Error& error) {
      throw LinkLost(error.place().file, error.problem());
    }
  }

  bool wanted() const { return !options_.keep_going || options_.keep_going(); }

  /// Brings an idle controller into the state that the program needs; leaves a running one alone.
  void prepare(Session& session) {
    const auto status = session.request(protocol::GetStatus{});
    if (status.program_id == id_ &&
        status.state != static_cast<std::uint8_t>(protocol::State::idle))
      return;
    if (status.fault == static_cast<std::uint8_t>(protocol::Fault::link_lost)) {
      clear_link_lost(session);
    } else if (status.fault != 0) {
      throw instrument::Faulted(session.name(), status.fault, "before the scan began");
    }
    if (status.program_id != 0 && status.program_id != id_) release_other_program(session, status);
    if (status.homed_mask != all_axes)
      home(session, static_cast<std::uint8_t>(all_axes & ~status.homed_mask));
    protocol::SetLockin lockin;
    lockin.reference_mhz = static_cast<std::uint32_t>(std::lround(1000 * plan_.reference_hz));
    lockin.harmonic = 1;
    lockin.settle_ms = static_cast<std::uint16_t>(plan_.settle_ms);
    lockin.blocks = 10;
    session.request(lockin);
  }

  void release_other_program(Session& session, const protocol::Status& status) {
    if (status.first_unacknowledged < status.next_record && !options_.overwrite) {
      throw Error({session.name()},
                  fmt::format("the controller still holds {} records of another scan",
                              status.next_record - status.first_unacknowledged),
                  "finish that scan with --resume, or discard them with --force");
    }
    // A program that ran to its end needs no ending.
    if (status.state != static_cast<std::uint8_t>(protocol::State::idle)) {
      session.request(protocol::ProgramControl{2});
    }
  }

  /// The fault that an earlier host's silence left; refused while the axes still come to rest.
  void clear_link_lost(Session& session) {
    for (int tries_left = 100;; --tries_left) {
      try {
        session.request(
            protocol::ClearFault{static_cast<std::uint8_t>(protocol::Fault::link_lost)});
        return;
      } catch (const instrument::Refused& refused) {
        if (refused.refusal() != protocol::Refusal::busy || tries_left == 0) throw;
      }
      session.poll(std::chrono::milliseconds(50));
    }
  }

  void home(Session& session, std::uint8_t mask) {
    session.request(protocol::Home{mask});
    for (;;) {
      session.poll(std::chrono::milliseconds(50));
      while (session.next_event()) {
      }
      const auto status = session.request(protocol::GetStatus{});
      if (status.fault != 0)
        throw instrument::Faulted(session.name(), status.fault, "while homing");
      if (status.homed_mask == all_axes &&
          status.state == static_cast<std::uint8_t>(protocol::State::idle))
        return;
      if (options_.progress) options_.progress({next_, summary_.total, "homing"});
      if (!wanted()) {
        session.request(protocol::Stop{});
        throw Error("stopped while homing", "nothing was measured; start again");
      }
    }
  }

  void start_journal(Session& session) {
    const auto now = session.request(protocol::GetStatus{});
    if (writer_) return;
    base_ = {session.device().boot_id, static_cast<double>(now.time_us)};
    if (options_.overwrite) std::filesystem::remove(journal_path(options_.output));
    writer_ = formats::JournalWriter::create(journal_path(options_.output),
                                             header_for(plan_, program_, options_, session, base_));
  }

  /// A controller that was restarted began its time anew: go on where the last record was.
  void rebase(Session& session, double last_time_s) {
    if (session.device().boot_id == base_.boot_id) return;
    const auto now = session.request(protocol::GetStatus{});
    base_ = {session.device().boot_id, static_cast<double>(now.time_us) - 1e6 * last_time_s};
  }

  void report(std::uint32_t done) {
    next_ = done;
    if (!options_.progress) return;
    std::string note;
    if (done < summary_.total) {
      const auto& row = program_.rows[done];
      note = fmt::format("{:g} nm, theta_i {:g}°, theta_r {:g}°", row.wavelength_nm,
                         row.theta_i_deg, row.theta_r_deg);
    }
    options_.progress({done, summary_.total, note});
  }

  /// Builds scan.h5 from the journal; the journal goes when nothing is missing.
  void finish_file() {
    if (!writer_) return;
    writer_.reset();
    const auto journal_file = journal_path(options_.output);
    const auto journal = formats::read_journal(journal_file);
    const auto table = formats::build_scan_table(journal);
    formats::write_scan_h5(options_.output, table, journal.header.provenance);
    summary_.records = static_cast<std::uint32_t>(table.size());
    summary_.saturated = 0;
    for (const int flag : table.saturated) summary_.saturated += static_cast<std::uint64_t>(flag);
    if (table.size() > 0) summary_.instrument_time_s = table.time_s.back();
    if (journal.complete()) std::filesystem::remove(journal_file);
  }

  const Plan& plan_;
  const RunOptions& options_;
  Program program_;
  std::uint32_t id_;
  std::optional<formats::JournalWriter> writer_;
  TimeBase base_;
  std::uint32_t next_ = 0;
  double last_time_s_ = 0;
  RunSummary summary_;
};

}  // namespace

std::filesystem::path journal_path(const std::filesystem::path& output) {
  return output.string() + ".journal";
}

RunSummary run_scan(const Plan& plan, const RunOptions& options) {
  return Runner(plan, options).run();
}

}  // namespace umov::scan
