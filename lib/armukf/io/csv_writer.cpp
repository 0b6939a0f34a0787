#include "armukf/io/csv_writer.hpp"

#include <stop_token>
#include <system_error>
#include <utility>

#include "armukf/io/atomic_file.hpp"

namespace armukf {
namespace {

constexpr std::size_t kBatch = std::size_t{1} << 17;  // bytes of cells, about as many of text

}  // namespace

CsvWriter::CsvWriter(const std::string& path, StopFlag stop)
    : owned_(open_for_writing(path)),
      descriptor_(owned_.number()),
      name_(shown_name(path)),
      stop_(stop) {}

CsvWriter::CsvWriter(int descriptor, std::string name, StopFlag stop)
    : descriptor_(descriptor), name_(std::move(name)), stop_(stop) {}

CsvWriter::~CsvWriter() {
  try {
    flush();
  } catch (const std::system_error&) {
  }
}

void CsvWriter::end_row() {
  CsvRows::end_row();
  hand_over_full();
}

void CsvWriter::append_rows(std::string_view rows) {
  CsvRows::append_rows(rows);
  hand_over_full();
}

void CsvWriter::hand_over_full() {
  if (size() < kBatch) return;
  if (std::thread::hardware_concurrency() < 2) return flush();
  std::unique_lock lock(mutex_);
  wait_until_written(lock);
  swap(given_);
  busy_ = true;
  if (!worker_.joinable())
    worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  changed_.notify_all();
}

void CsvWriter::flush() {
  std::unique_lock lock(mutex_);
  wait_until_written(lock);
  write(*this);
}

/// Until the thread has nothing to do; what it failed at is thrown here.
void CsvWriter::wait_until_written(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [this] { return !busy_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void CsvWriter::write(CsvRows& rows) {
  text_.clear();
  rows.append_to(text_);
  if (closed_) return;
  try {
    if (!write_all(descriptor_, text_, name_, stop_)) closed_ = true;
  } catch (const std::system_error&) {
    closed_ = true;
    throw;
  }
}

void CsvWriter::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return busy_; })) {
    lock.unlock();
    try {
      write(given_);
    } catch (const std::system_error&) {
      failure_ = std::current_exception();  // which is read once it is no more busy
    }
    lock.lock();
    busy_ = false;
    changed_.notify_all();
  }
}

}  // namespace armukf
