#include "arrays.hpp"

#include <fmt/format.h>

#include <cmath>

#include "armukf/core/error.hpp"

namespace armukf::python {
namespace {

constexpr py::ssize_t kColumns = 3;  // t, u, y
static_assert(sizeof(Sample) == kColumns * sizeof(double));

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(fmt::format("{}: {}", name, what));
}

std::string text_of(const py::handle& object) { return py::str(object); }

/// Whether it is an array that can be read as samples where it lies.
py::array checked_array(const NamedRows& rows) {
  const auto& [name, object] = rows;
  if (!py::isinstance<py::array>(object))
    fail(name, fmt::format("must be a NumPy array, not {}",
                           text_of(py::type::of(object).attr("__name__"))));
  auto array = py::reinterpret_borrow<py::array>(object);
  if (!array.dtype().equal(py::dtype::of<double>()))
    fail(name, fmt::format("must hold float64, not {}; see numpy.ndarray.astype",
                           text_of(array.dtype())));
  if (array.ndim() != 2 || array.shape(1) != kColumns)
    fail(name, fmt::format("must have shape (n, 3), a row of t, u, y per sample, not {}",
                           text_of(array.attr("shape"))));
  constexpr int kWanted = int{py::array::c_style} | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  if ((array.flags() & kWanted) != kWanted)
    fail(name, "must be in C order, row by row; see numpy.ascontiguousarray");
  return array;
}

void check_finite(double value, const std::string& name, std::size_t row, const char* column) {
  if (!std::isfinite(value))
    throw InputError(fmt::format("{}[{}]", name, row), 0, column,
                     fmt::format("{} is not a finite number", value));
}

}  // namespace

void check(std::span<const Sample> samples, const std::string& name, double last_t) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto& [t, u, y] = samples[k];
    check_finite(t, name, k, "t");
    check_finite(u, name, k, "u");
    if (!std::isnan(y)) check_finite(y, name, k, "y");
    if (!(t > last_t))
      throw InputError(fmt::format("{}[{}]", name, k), 0, "t",
                       fmt::format("time {}: {} s after {} s",
                                   t == last_t ? "repeats" : "goes back", t, last_t));
    last_t = t;
  }
}

std::span<const Sample> samples_in(const NamedRows& rows, double last_t) {
  const py::array array = checked_array(rows);
  const std::span samples(static_cast<const Sample*>(array.data()),
                          static_cast<std::size_t>(array.shape(0)));
  check(samples, rows.first, last_t);
  return samples;
}

Record record_in(const NamedRows& rows) {
  const auto samples = samples_in(rows);
  if (samples.empty()) fail(rows.first, "has no samples");
  return {.name = rows.first, .samples = {samples.begin(), samples.end()}};
}

std::vector<Record> records_in(const std::vector<NamedRows>& rows) {
  std::vector<Record> records;
  records.reserve(rows.size());
  for (const NamedRows& record : rows) records.push_back(record_in(record));
  return records;
}

py::array_t<double> as_array(std::vector<Sample> samples) {
  auto* kept = new std::vector<Sample>(std::move(samples));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<Sample>*>(p); });
  return py::array_t<double>({static_cast<py::ssize_t>(kept->size()), kColumns},
                             reinterpret_cast<const double*>(kept->data()), owner);
}

py::array_t<double> copied(std::span<const double> numbers) {
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

}  // namespace armukf::python
