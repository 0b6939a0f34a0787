// The C++ loop that Session.run of the Python package is held against: takes the samples of a file,
// t, u, y as numbers of 64 bits, one by one, and prints the processor time of each of ROUNDS runs,
// in seconds: session_loop FILE ROUNDS

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <vector>

#include "armukf/armukf.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return EXIT_FAILURE;
  std::vector<armukf::Sample> samples;
  std::ifstream file(argv[1], std::ios::binary);
  for (double row[3]; file.read(reinterpret_cast<char*>(row), sizeof row);)
    samples.push_back({.t = row[0], .u = row[1], .y = row[2]});
  for (int round = 0; round < std::atoi(argv[2]); ++round) {
    armukf::Session session(armukf::published_arm(), {});
    const std::clock_t begin = std::clock();
    double sum = 0.0;
    for (const armukf::Sample& sample : samples) sum += session.step(sample).values.back();
    std::cout << static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC << '\n';
    if (!(sum > 0.0)) return EXIT_FAILURE;
  }
}
