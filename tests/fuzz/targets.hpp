#pragma once

#include <string_view>

/// What is fuzzed: each takes any bytes, and must neither crash, hang, nor do what is undefined.
/// Under libFuzzer (option ARMUKF_FUZZ) each is a program of its own; the corpus goes through all
/// of them in every build (corpus_test.cpp). A finding becomes a file of the corpus.
namespace armukf::fuzz {

/// A record, read with every faulty row passed over or salvaged.
void csv(std::string_view bytes);

/// A model file; what it accepts must read back from what it writes.
void model(std::string_view bytes);

/// A checkpoint, as it is and as the sealed content of one; whatever is accepted must go on.
void checkpoint(std::string_view bytes);

/// A whole estimate: a byte that chooses filter and window, then three doubles per sample. What is
/// believed stays finite.
void estimate(std::string_view bytes);

}  // namespace armukf::fuzz
