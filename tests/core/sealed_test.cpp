#include "armukf/core/sealed.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr Seal kSeal{"armukf_x", 3};

std::string refusal(const std::string& bytes, const Seal& seal = kSeal) {
  try {
    unsealed(seal, bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Sealed, ContentComesBack) {
  for (const std::string& content : {std::string(), std::string("a\0b", 3), std::string(5000, 'x')})
    EXPECT_EQ(unsealed(kSeal, sealed(kSeal, content)), content);
}

TEST(Sealed, EveryWrongBitIsSeen) {
  const std::string whole = sealed(kSeal, "the belief");
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string wrong = whole;
    wrong[bit / 8] = static_cast<char>(wrong[bit / 8] ^ (1 << bit % 8));
    EXPECT_NE(refusal(wrong), "") << bit;
  }
}

TEST(Sealed, EveryCutIsSeenAndSoIsWhatFollows) {
  const std::string whole = sealed(kSeal, "the belief");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(refusal(whole.substr(0, size)), "") << size;
  EXPECT_NE(refusal(whole + "x"), "");
}

TEST(Sealed, RefusalsTellWhy) {
  const std::string whole = sealed(kSeal, "the belief");
  EXPECT_EQ(refusal("t,u,y\n0,1,2\n"), "is no checkpoint of armukf");
  EXPECT_EQ(refusal(""), "is no checkpoint of armukf");
  EXPECT_EQ(refusal(whole, {"armukf_y", 3}),
            "is a checkpoint of armukf, but of another kind: with --key it is one of many arms");
  EXPECT_EQ(refusal(whole, {"armukf_x", 2}), "is of version 3; this program knows version 2");
  EXPECT_EQ(refusal(whole.substr(0, 30)), "is cut short: 30 bytes of 34");
  EXPECT_EQ(refusal(whole.substr(0, 33) + "x"), "is damaged: its checksum is wrong");
}

struct Whole {
  double number = 0.0;
  bool truth = false;
  std::optional<double> maybe;
  std::array<int, 3> few{};
  std::vector<double> many;
  std::string text;

  template <class Archive>
  void archive(Archive& archive) {
    archive(number, truth, maybe, few, many, text);
  }
};

TEST(Archive, WhatGoesInComesOut) {
  Whole in{0.1, true, 3.5, {1, 2, 3}, {4.0, 5.0}, "six"};
  OutArchive out;
  out(in);
  Whole back;
  back.many.resize(7);
  InArchive archive(out.bytes());
  archive(back);
  EXPECT_EQ(back.number, in.number);
  EXPECT_TRUE(back.truth);
  EXPECT_EQ(back.maybe, in.maybe);
  EXPECT_EQ(back.few, in.few);
  EXPECT_EQ(back.many, in.many);
  EXPECT_EQ(back.text, in.text);
  EXPECT_EQ(archive.left(), 0U);
}

TEST(Archive, BytesThatEndTooEarlyAreRefusedWhateverLengthTheyClaim) {
  Whole in;
  in.many = {4.0, 5.0};
  in.text = "six";
  OutArchive out;
  out(in);
  for (std::size_t size = 0; size < out.bytes().size(); ++size) {
    Whole back;
    InArchive archive(std::string_view(out.bytes()).substr(0, size));
    EXPECT_THROW(archive(back), InputError) << size;
  }
  OutArchive huge;
  std::uint64_t length = ~std::uint64_t{0};
  huge(length);
  std::string text;
  InArchive archive(huge.bytes());
  EXPECT_THROW(archive(text), InputError);
}

}  // namespace
}  // namespace armukf
