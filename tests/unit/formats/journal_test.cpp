#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/journal_records.hpp"
#include "host/formats/scan_csv.hpp"
#include "tests/unit/formats/scratch_folder.hpp"

namespace umov::formats {
namespace {

using testing::ScratchFolder;

constexpr std::size_t frame_size = frame_overhead + record_payload_size;

ScanRecord record(std::int64_t index) {
  ScanRecord r;
  r.index = index;
  r.time_s = 0.5 * static_cast<double>(index);
  r.theta_i_deg = 30;
  r.theta_r_deg = static_cast<double>(index % 80);
  r.wavelength_nm = 532;
  r.polarizer_deg = 90;
  r.analyzer_deg = open_axis;
  r.direction = index % 2 == 0 ? 1 : -1;
  r.gain = 100;
  r.x_v = 1e-3 / 7 * static_cast<double>(index + 1);
  r.monitor_v = 1.08;
  r.saturated = index % 5 == 0;
  r.shutter_open = index % 3 != 0;
  return r;
}

JournalHeader header(std::uint64_t rows) {
  JournalHeader h;
  h.program_id = 0xfeed;
  h.row_count = rows;
  h.provenance.plan = "sample = \"x\"\n";
  h.provenance.created = "2024-05-01T12:00:00Z";
  h.keys = {{"sample", "x"}, {"solid_angle_sr", "1e-4"}};
  h.blocks = {{"main", 0, 5, {}}, {"flip", 6, 20, {{"sample_azimuth_deg", "180"}}}};
  return h;
}

std::string journal_bytes(const std::filesystem::path& path, int records) {
  JournalWriter writer = JournalWriter::create(path, header(21));
  for (int i = 0; i < records; ++i) {
    const ScanRecord one = record(i);
    writer.append({&one, 1});
  }
  writer.sync();
  return read_whole_file(path);
}

Journal parse(const std::string& bytes) {
  return parse_journal(std::as_bytes(std::span(bytes)), "test");
}

TEST(Journal, GivesBackHeaderAndRecords) {
  const ScratchFolder folder;
  journal_bytes(folder / "j", 10);
  const Journal journal = read_journal(folder / "j");
  EXPECT_EQ(journal.header.program_id, 0xfeedu);
  EXPECT_EQ(journal.header.row_count, 21u);
  EXPECT_EQ(journal.header.provenance.plan, "sample = \"x\"\n");
  EXPECT_EQ(journal.header.keys[1].second, "1e-4");
  EXPECT_EQ(journal.header.blocks[1].settings[0].first, "sample_azimuth_deg");
  ASSERT_EQ(journal.records.size(), 10u);
  EXPECT_EQ(journal.records[7].x_v, record(7).x_v);
  EXPECT_TRUE(is_open(journal.records[7].analyzer_deg));
  EXPECT_EQ(journal.records[7].direction, -1);
  EXPECT_TRUE(journal.records[5].saturated);
  EXPECT_FALSE(journal.records[6].shutter_open);
  EXPECT_EQ(journal.next_index(), 10);
  EXPECT_FALSE(journal.complete());
}

TEST(Journal, CutAtEveryByteKeepsEveryWholeRecord) {
  const ScratchFolder folder;
  const std::string whole = journal_bytes(folder / "j", 6);
  const std::size_t start = whole.size() - 6 * frame_size;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    if (size < start) {
      EXPECT_THROW(parse(whole.substr(0, size)), Error) << size;
      continue;
    }
    const Journal journal = parse(whole.substr(0, size));
    const std::size_t records = (size - start) / frame_size;
    ASSERT_EQ(journal.records.size(), records) << size;
    EXPECT_EQ(journal.valid_bytes, start + records * frame_size);
    EXPECT_EQ(journal.torn_bytes, size - journal.valid_bytes);
    EXPECT_EQ(journal.damaged_bytes, 0u);
  }
}

TEST(Journal, ResumedAfterACutAtEveryByteItEndsWhole) {
  const ScratchFolder folder;
  const std::string whole = journal_bytes(folder / "j", 3);
  const std::size_t start = whole.size() - 3 * frame_size;
  for (std::size_t size = start; size <= whole.size(); size += 7) {
    std::ofstream(folder / "cut", std::ios::binary) << whole.substr(0, size);
    Journal recovered;
    JournalWriter writer = JournalWriter::resume(folder / "cut", recovered);
    for (std::int64_t i = recovered.next_index(); i < 3; ++i) {
      const ScanRecord one = record(i);
      writer.append({&one, 1});
    }
    writer.sync();
    EXPECT_TRUE(read_whole_file(folder / "cut") == whole) << size;
  }
}

TEST(Journal, AFlippedBitCostsItsOwnRecordOnly) {
  const ScratchFolder folder;
  const std::string whole = journal_bytes(folder / "j", 5);
  const std::size_t start = whole.size() - 5 * frame_size;
  for (std::size_t at = start; at < whole.size(); ++at)
    for (const int bit : {0, 7}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      const Journal journal = parse(damaged);
      const std::size_t hit = (at - start) / frame_size;
      ASSERT_EQ(journal.records.size(), 4u) << at;
      for (const ScanRecord& r : journal.records)
        EXPECT_NE(r.index, static_cast<std::int64_t>(hit));
      EXPECT_EQ(journal.next_index(), static_cast<std::int64_t>(hit));
      EXPECT_EQ(journal.damaged_bytes + journal.torn_bytes, frame_size);
    }
}

TEST(Journal, AFlippedBitInTheHeaderIsRefused) {
  const ScratchFolder folder;
  const std::string whole = journal_bytes(folder / "j", 1);
  for (std::size_t at = 0; at < whole.size() - frame_size; ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    EXPECT_THROW(parse(damaged), Error) << at;
  }
}

TEST(Journal, TheFirstOfDoubleRecordsCounts) {
  const ScratchFolder folder;
  {
    JournalWriter writer = JournalWriter::create(folder / "j", header(3));
    ScanRecord again = record(1);
    again.x_v = 99;
    const std::vector<ScanRecord> all = {record(0), record(1), again, record(2), record(0)};
    writer.append(all);
    writer.sync();
  }
  const Journal journal = read_journal(folder / "j");
  ASSERT_EQ(journal.records.size(), 3u);
  EXPECT_EQ(journal.records[1].x_v, record(1).x_v);
  EXPECT_TRUE(journal.complete());
}

TEST(Journal, BuildsASortedCanonicalScanWithBlocksCutToItsRows) {
  const ScratchFolder folder;
  {
    JournalWriter writer = JournalWriter::create(folder / "j", header(21));
    const std::vector<ScanRecord> late = {record(0), record(1), record(2), record(4),
                                          record(5), record(6), record(7), record(3)};
    writer.append(late);
    writer.sync();
  }
  const ScanTable table = build_scan_table(read_journal(folder / "j"));
  ASSERT_EQ(table.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(table.index[i], static_cast<std::int64_t>(i));
  ASSERT_EQ(table.blocks.size(), 2u);
  EXPECT_EQ(table.blocks[1].last, 7);
  EXPECT_EQ(table.key("sample"), "x");
  const std::string text = scan_csv_text(table);
  EXPECT_EQ(scan_csv_text(parse_scan_csv(text, "text")), text);
  EXPECT_EQ(table.x_v[0], 0.00014285714);
}

TEST(Journal, AnExistingOneIsNeitherReplacedNorSharedByTwoWriters) {
  const ScratchFolder folder;
  JournalWriter writer = JournalWriter::create(folder / "j", header(3));
  EXPECT_THROW(JournalWriter::create(folder / "j", header(3)), Error);
  Journal recovered;
  EXPECT_THROW(JournalWriter::resume(folder / "j", recovered), Error) << "still being written";
  JournalWriter moved = std::move(writer);
  const ScanRecord one = record(0);
  moved.append({&one, 1});
  moved.sync();
  EXPECT_EQ(read_journal(folder / "j").records.size(), 1u);
  EXPECT_THROW(JournalWriter::create(folder / "no" / "j", header(3)), Error);
  EXPECT_THROW(JournalWriter::resume(folder / "none", recovered), Error);
}

TEST(Journal, AFullDiskIsReportedAndEndsTheWriting) {
  // A limit on the file size stands for a full disk: write(2) fails part of the way through.
  const ScratchFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    JournalWriter writer = JournalWriter::create(folder / "j", header(100));
    const auto size = std::filesystem::file_size(folder / "j");
    const rlimit limit{size + 5 * frame_size + 40, size + 5 * frame_size + 40};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::vector<ScanRecord> many;
    for (int i = 0; i < 20; ++i) many.push_back(record(i));
    int refusals = 0;
    for (int attempt = 0; attempt < 2; ++attempt) {
      try {
        writer.append(many);
      } catch (const Error&) {
        ++refusals;
      }
    }
    try {
      writer.sync();
    } catch (const Error&) {
      ++refusals;
    }
    ::_exit(refusals);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 3);
  const Journal journal = read_journal(folder / "j");
  EXPECT_EQ(journal.records.size(), 5u);
  EXPECT_EQ(journal.torn_bytes, 40u);
}

TEST(Journal, KilledWritersLoseNothingTheyReportedAsSynced) {
  const ScratchFolder folder;
  int kept_total = 0;
  for (int trial = 0; trial < 8; ++trial) {
    const auto path = folder / ("j" + std::to_string(trial));
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      JournalWriter writer = JournalWriter::create(path, header(1'000'000));
      for (std::int64_t i = 0;; i += 3) {
        const std::vector<ScanRecord> batch = {record(i), record(i + 1), record(i + 2)};
        writer.append(batch);
        writer.sync();
        const std::int64_t safe = i + 3;
        if (::write(pipe_ends[1], &safe, sizeof safe) != sizeof safe) ::_exit(1);
      }
    }
    ::close(pipe_ends[1]);
    std::int64_t safe = 0, told = 0;
    while (safe < 20 + 15 * trial && ::read(pipe_ends[0], &told, sizeof told) == sizeof told)
      safe = told;
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(pipe_ends[0], &told, sizeof told) == sizeof told) safe = told;
    ::close(pipe_ends[0]);
    Journal recovered;
    const JournalWriter writer = JournalWriter::resume(path, recovered);
    EXPECT_GE(recovered.next_index(), safe);
    EXPECT_EQ(recovered.records.size(), static_cast<std::size_t>(recovered.next_index()));
    kept_total += static_cast<int>(recovered.records.size());
  }
  EXPECT_GT(kept_total, 8 * 20);
}

}  // namespace
}  // namespace umov::formats
