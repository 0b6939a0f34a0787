#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "armukf/core/record.hpp"

/// NumPy arrays as samples, and results as NumPy arrays, without copies. A record is an array of
/// float64, shape (n, 3), C order: t (s), u (N.m), y (rad/s, NaN where it is missing).
namespace armukf::python {

namespace py = pybind11;

/// An array beside its name in messages.
using NamedRows = std::pair<std::string, py::object>;

/// Before any sample, in s.
inline constexpr double kNoTime = -std::numeric_limits<double>::infinity();

/// Takes what the reader of files takes: InputError, `NAME[ROW]: COLUMN: what is wrong`, where a
/// time or a torque is no finite number, a speed is infinite, or times do not rise, the first
/// beyond `last_t` (s).
void check(std::span<const Sample> samples, const std::string& name, double last_t);

/// The samples that an array holds, checked like that; valid as long as it is.
std::span<const Sample> samples_in(const NamedRows& rows, double last_t = kNoTime);

/// InputError where there are none.
Record record_in(const NamedRows& rows);
std::vector<Record> records_in(const std::vector<NamedRows>& rows);

/// Numbers that move into an array, which frees them in the end. `rows` of equal length each, where
/// that is not 0.
template <class Number>
py::array_t<Number> as_array(std::vector<Number> numbers, std::size_t rows = 0) {
  auto* kept = new std::vector<Number>(std::move(numbers));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<Number>*>(p); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(kept->size())};
  if (rows > 0) shape = {static_cast<py::ssize_t>(rows), shape[0] / static_cast<py::ssize_t>(rows)};
  return py::array_t<Number>(std::move(shape), kept->data(), owner);
}

/// The same of samples, shape (n, 3).
py::array_t<double> as_array(std::vector<Sample> samples);

/// Numbers that others go on to change.
py::array_t<double> copied(std::span<const double> numbers);

/// An array that is still to be filled. NumPy's own would ask for huge pages, for which the kernel
/// may take a third of the time that filling them with estimates does.
template <class Number>
py::array_t<Number> room_for(const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  auto* kept = new Number[count];
  const py::capsule owner(kept, [](void* p) { delete[] static_cast<Number*>(p); });
  return py::array_t<Number>(shape, kept, owner);
}

}  // namespace armukf::python
