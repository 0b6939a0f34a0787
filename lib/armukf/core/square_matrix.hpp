#pragma once

#include <cstddef>
#include <vector>

namespace armukf {

/// A square matrix as results carry it to users, row by row; for computing there is Eigen, whose
/// types do not cross from one build of the library to another program.
class SquareMatrix {
 public:
  SquareMatrix() = default;
  explicit SquareMatrix(int size)
      : size_(size), entries_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size)) {}

  int size() const { return size_; }
  double& operator()(int i, int j) { return entries_[at(i, j)]; }
  double operator()(int i, int j) const { return entries_[at(i, j)]; }

 private:
  std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(size_) +
           static_cast<std::size_t>(j);
  }

  int size_ = 0;
  std::vector<double> entries_;
};

}  // namespace armukf
