#include "hil/blind/case_set.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/sha256.hpp"

namespace umov::blind {
namespace {

namespace fs = std::filesystem;

constexpr const char* readme =
    "# Withheld-effect cases\n\n"
    "Each folder `case_NNNN` holds `scan.csv`, one raw scan of one sample in the Scan CSV "
    "contract. "
    "In some of them an effect, or several, is in the instrument or on the sample that a base "
    "model "
    "does not have; in others there is none. The question is the same for all: where does a "
    "simulation "
    "miss the measurement, which effect causes it, and how far does the gap shrink with it?\n\n"
    "The answers are kept elsewhere. `SEAL` holds the SHA-256 of their file, written before any "
    "diagnosis is run.\n";

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) throw Error({path.string()}, "cannot be written", "check space and permissions");
}

void require_places(const fs::path& folder, const fs::path& truth_folder) {
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder))) {
    throw Error({folder.string()}, "is there already and not an empty folder", "name a new one");
  }
  if (fs::exists(truth_folder / truth_name)) {
    throw Error({(truth_folder / truth_name).string()}, "is there already",
                "name another folder for the truth");
  }
  const fs::path outer = fs::weakly_canonical(folder);
  for (fs::path inner = fs::weakly_canonical(truth_folder); inner.has_relative_path();
       inner = inner.parent_path()) {
    if (inner == outer) {
      throw Error({truth_folder.string()}, "lies within the folder of the cases",
                  "keep the truth where whoever diagnoses does not look");
    }
  }
}

/// Runs `work(i)` for i < count on some threads; the first exception is thrown again.
void for_each_case(std::size_t count, int threads, const std::function<bool()>& keep_going,
                   const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto loop = [&] {
    for (std::size_t i = next++; i < count && !stop; i = next++) {
      try {
        if (keep_going && !keep_going()) {
          stop = true;
          return;
        }
        work(i);
      } catch (const std::exception&) {
        const std::scoped_lock lock(mutex);
        if (!failure) failure = std::current_exception();
        stop = true;
      }
    }
  };
  const unsigned wanted =
      threads > 0 ? static_cast<unsigned>(threads) : std::thread::hardware_concurrency();
  std::vector<std::thread> pool;
  for (unsigned t = 1; t < std::min<std::size_t>(std::max(1u, wanted), count); ++t)
    pool.emplace_back(loop);
  loop();
  for (std::thread& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

bool make_case_set(const fs::path& folder, const fs::path& truth_folder,
                   const MakeOptions& options) {
  require_places(folder, truth_folder);
  fs::create_directories(folder);
  fs::create_directories(truth_folder);
  write_text(folder / "README.md", readme);
  const std::vector<CaseClass> classes = case_classes(options.cases, options.seed, options.draws);
  TruthFile truth;
  truth.seed = options.seed;
  truth.cases.resize(options.cases);
  std::mutex mutex;
  std::size_t done = 0;
  for_each_case(options.cases, options.threads, options.keep_going, [&](std::size_t i) {
    CaseTruth one = make_case(options.seed, i + 1, classes[i], options.draws);
    const fs::path own = folder / one.name;
    fs::create_directories(own);
    formats::write_scan_csv(own_scan(one), own / "scan.csv");
    const std::scoped_lock lock(mutex);
    truth.cases[i] = std::move(one);
    ++done;
    if (options.progress) options.progress(done);
  });
  if (done < options.cases) return false;
  const std::string text = truth_text(truth);
  const fs::path truth_path = truth_folder / truth_name;
  write_text(truth_path, text);
  fs::permissions(truth_path, fs::perms::owner_read | fs::perms::owner_write);
  formats::Sha256 hash;
  hash.update(text);
  write_text(folder / seal_name, "sha256 " + hash.hex_digest() + "  " + truth_name + "\ncases " +
                                     std::to_string(options.cases) + "\n");
  return true;
}

Seal read_seal(const fs::path& folder) {
  const fs::path path = folder / seal_name;
  std::ifstream file(path);
  std::string word, name;
  Seal seal;
  if (!(file >> word >> seal.sha256 >> name) || word != "sha256" || seal.sha256.size() != 64 ||
      !(file >> word >> seal.cases) || word != "cases") {
    throw Error({path.string()}, "is no seal of a complete set of cases",
                "name the folder that `umov blind make` wrote, and let it finish");
  }
  return seal;
}

bool seal_fits(const fs::path& folder, const fs::path& truth_folder) {
  return read_seal(folder).sha256 == formats::sha256_of_file(truth_folder / truth_name);
}

}  // namespace umov::blind
