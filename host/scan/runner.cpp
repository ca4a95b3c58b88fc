#include "host/scan/runner.hpp"

#include <algorithm>
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
#include "host/instrument/program_control.hpp"
#include "host/instrument/program_stream.hpp"
#include "host/instrument/refusals.hpp"
#include "host/instrument/session.hpp"
#include "host/scan/preparation.hpp"
#include "host/scan/program_rows.hpp"
#include "host/scan/record_scale.hpp"

namespace umov::scan {
namespace {

using instrument::LinkLost;
using instrument::ProgramStream;
using instrument::Session;

/// The clock of a scan: which boot of the controller it began in and when.
struct TimeBase {
  std::uint32_t boot_id = 0;
  double start_us = 0;
};

std::string name_text(const protocol::Name& name) {
  const std::string text(name.begin(), name.end());
  return text.substr(0, text.find('\0'));
}

/// Records on their way to the journal.
class JournalSink : public instrument::RecordSink {
 public:
  /// `base` is the clock of the records so far, the last of them at `last_time_s`.
  JournalSink(formats::JournalWriter& journal, const std::vector<PlanRow>& rows,
              const TimeBase& base, double last_time_s)
      : journal_(&journal), rows_(&rows), base_(base), last_time_s_(last_time_s) {}

  /// Records come from this controller from now on.
  void connect(const protocol::HelloReply& device) { device_ = device; }
  void take(const protocol::Record& record) override {
    const PlanRow& row = rows_->at(record.index);
    const auto time_us = static_cast<double>(record.time_us);
    if (device_.boot_id != base_.boot_id || time_us - base_.start_us < 1e6 * last_time_s_) {
      // The controller was restarted and began its time anew: go on a dwell after the last record.
      const double time_s = last_time_s_ + 1e-3 * row.dwell_ms;
      base_ = {device_.boot_id, time_us - 1e6 * time_s};
    }
    pending_.push_back(scaled(record, row, device_, base_.start_us));
    last_time_s_ = pending_.back().time_s;
  }
  void secure() override {
    journal_->append(pending_);
    journal_->sync();
    pending_.clear();
  }

 private:
  formats::JournalWriter* journal_;
  const std::vector<PlanRow>* rows_;
  protocol::HelloReply device_{};
  TimeBase base_;
  double last_time_s_ = 0;
  std::vector<formats::ScanRecord> pending_;
};

/// A device that is plugged in again shall not wait long for its host.
constexpr std::chrono::milliseconds longest_reconnect_wait{500};

/// What tells one instrument from another: name and serial number.
std::string device_key(const protocol::HelloReply& device) {
  return fmt::format("{} {}", name_text(device.device_name), name_text(device.serial));
}

std::string settings_text(const TimeBase& base, const Plan& plan,
                          const protocol::HelloReply& device) {
  return nlohmann::json{{"boot_id", base.boot_id},
                        {"start_us", base.start_us},
                        {"reference_source", plan.external_reference ? "external" : "internal"},
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
  set("device", device_key(device));
  set("adc_step_v", fmt::format("{:.6g}", adc_step_v));
  set("adc_full_scale_v", fmt::format("{:.6g}", adc_step_v * device.adc_codes / 2));
  header.provenance.program = options.program;
  header.provenance.command = options.command;
  header.provenance.created = formats::utc_now();
  header.provenance.device = fmt::format("{} at {}", device_key(device), session.name());
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
      : plan_(plan),
        options_(options),
        program_(expand(plan)),
        stretches_(stretches(program_, options.standing)),
        id_(program_id(plan)) {
    summary_.total = static_cast<std::uint32_t>(program_.rows.size());
  }

  RunSummary run() {
    if (!options_.arrange) require_plain(stretches_, plan_.name);
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
      for (const auto& [key, value] : found.header.keys) {
        if (key == "device") begun_on_ = value;
      }
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

  /// Every stretch in its set-up.
  void measure() {
    if (summary_.resumed_from > 0 && set_up_may_have_changed()) present_.reset();
    bool complete = true;
    for (const Stretch& stretch : stretches_) {
      if (next_ >= stretch.end) continue;
      complete = arrange(stretch.arrangement, stretch.blocks) && measure(stretch);
      if (!complete) break;
    }
    summary_.complete = complete;
    if (complete) arrange({}, "");
  }

  /// Whether the interrupted scan had come to where the set-up changes.
  bool set_up_may_have_changed() const {
    return std::any_of(stretches_.begin(), stretches_.end(), [this](const Stretch& stretch) {
      return !stretch.arrangement.plain() && stretch.first <= next_;
    });
  }

  /// False when the scan was called off instead.
  bool arrange(const Arrangement& wanted, const std::string& blocks) {
    if (present_ == wanted) return true;
    if (!checked_) look_at_instrument();
    if (options_.progress) {
      options_.progress({next_, summary_.total, "set-up: " + wanted.text()});
    }
    try {
      if (!options_.arrange({wanted, present_, blocks})) return false;
    } catch (const Error&) {
      finish_file();
      throw;
    }
    present_ = wanted;
    return true;
  }

  /// Before someone goes to work on it: is it there, the right one, and able to do the plan?
  void look_at_instrument() {
    Session session(options_.connect());
    check(session);
  }

  void check(Session& session) {
    refuse_another_instrument(session.device(), session.name());
    if (!checked_) check_against_device(plan_, program_, session);
    checked_ = true;
    boot_id_ = session.device().boot_id;
  }

  /// The rows of one stretch, over any number of lost links. False when the scan was called off.
  bool measure(const Stretch& stretch) {
    std::optional<ProgramStream> stream;
    protocol::HelloReply device;
    int tries_left = options_.reconnects;
    auto wait = options_.reconnect_wait;
    const PreparationOptions preparation{.program_id = id_,
                                         .discard_records = options_.overwrite,
                                         .wanted = [this] { return wanted(); },
                                         .note =
                                             [this](const std::string& what) {
                                               if (options_.progress)
                                                 options_.progress({next_, summary_.total, what});
                                             },
                                         .link_lost_cleared = [this] { tell_of_link_lost(); }};
    std::uint64_t told_of = 0;
    for (;;) {
      try {
        Session session(connect(sink_.has_value()));
        device = session.device();
        const bool restarted = checked_ && device.boot_id != boot_id_;
        check(session);
        if (restarted && !stretch.arrangement.plain()) present_.reset();
        if (present_.has_value()) {
          if (!prepare_controller(session, plan_, preparation)) return false;
          if (stream) {
            ++summary_.lost_links;
          } else {
            start_journal(session);
            if (!sink_) sink_.emplace(*writer_, program_.rows, base_, last_time_s_);
            stream.emplace(
                instrument::ProgramOptions{
                    .program_id = id_, .row_count = stretch.end, .first_missing = next_},
                [&](std::uint32_t index) {
                  return program_row(program_.rows.at(index), index, device);
                },
                *sink_);
          }
          sink_->connect(device);
          const auto before = stream->next_index();
          return stream->run(session, [&](const ProgramStream& now) {
            if (now.counters().link_lost_cleared > told_of) {
              told_of = now.counters().link_lost_cleared;
              tell_of_link_lost();
            }
            if (now.next_index() > before) {
              tries_left = options_.reconnects;
              wait = options_.reconnect_wait;
            }
            report(now.next_index());
            return wanted();
          });
        }
      } catch (const LinkLost&) {
        if (!wanted()) return false;
        if (!sink_ || tries_left-- == 0) {
          finish_file();
          throw;
        }
        if (options_.progress)
          options_.progress({next_, summary_.total, "link lost, trying again"});
        if (!sleep_while_wanted(wait)) return false;
        wait = std::min(2 * wait, longest_reconnect_wait);
        continue;
      } catch (const Error&) {
        finish_file();
        throw;
      }
      // The controller was restarted, and perhaps the whole instrument: the session is closed.
      if (!arrange(stretch.arrangement, stretch.blocks)) return false;
    }
  }

  /// False when the scan was called off meanwhile.
  bool sleep_while_wanted(std::chrono::milliseconds duration) const {
    constexpr std::chrono::milliseconds slice{50};
    for (; wanted() && duration.count() > 0; duration -= slice) {
      std::this_thread::sleep_for(std::min(duration, slice));
    }
    return wanted();
  }

  /// Half a scan of one sample and half of another would look like one. The emulator's serial
  /// number stands for what is on its stage.
  void refuse_another_instrument(const protocol::HelloReply& device, const std::string& name) {
    const std::string found = device_key(device);
    if (begun_on_.empty()) begun_on_ = found;
    if (found == begun_on_) return;
    throw Error({name},
                fmt::format("the unfinished scan was begun on {}, this is {}", begun_on_, found),
                "go on with the same instrument (the emulator: the same sample, preset, plant "
                "settings and seed), or start over with --force");
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

  /// The controller went dark and this program turns its light on again: nobody else says so.
  void tell_of_link_lost() const {
    if (!options_.tell) return;
    options_.tell(
        "the controller had gone dark because no host spoke for 3 s (link_lost); the scan has "
        "cleared that fault and goes on");
  }

  bool wanted() const { return !options_.keep_going || options_.keep_going(); }

  void start_journal(Session& session) {
    const auto now = session.request(protocol::GetStatus{});
    if (writer_) return;
    base_ = {session.device().boot_id, static_cast<double>(now.time_us)};
    if (options_.overwrite) std::filesystem::remove(journal_path(options_.output));
    writer_ = formats::JournalWriter::create(journal_path(options_.output),
                                             header_for(plan_, program_, options_, session, base_));
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
    sink_.reset();
    writer_.reset();
    const auto journal_file = journal_path(options_.output);
    const auto journal = formats::read_journal(journal_file);
    if (journal.records.empty()) return;  // a file without a measurement would be none
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
  std::vector<Stretch> stretches_;
  std::uint32_t id_;
  std::optional<formats::JournalWriter> writer_;
  std::optional<JournalSink> sink_;                     ///< into writer_
  std::optional<Arrangement> present_ = Arrangement{};  ///< nullopt: not known
  bool checked_ = false;                                ///< the instrument can do the plan
  std::uint32_t boot_id_ = 0;                           ///< of the controller, where checked
  TimeBase base_;
  std::string begun_on_;  ///< device key of the scan; empty before the first connection
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
