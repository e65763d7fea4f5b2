#include "polyarm/users/password.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"

namespace polyarm::users {
namespace {

TEST(Password, FitsItsOwnHashOnly) {
  const std::string hash = hash_of("correct horse");
  EXPECT_TRUE(hash.starts_with("$y$")) << hash;
  EXPECT_TRUE(fits("correct horse", hash));
  EXPECT_FALSE(fits("correct horsf", hash));
  EXPECT_FALSE(fits("", hash));
  EXPECT_NE(hash_of("correct horse"), hash) << "each hash has a salt of its own";
}

TEST(Password, NobodyFitsAnything) {
  EXPECT_FALSE(fits("nobody has this password", hash_of_nobody()));
  EXPECT_FALSE(fits("", hash_of_nobody()));
}

TEST(Password, WhatIsNoHashFitsNothing) {
  for (const char* text : {"", "$", "$y$", "$y$j9T$", "*0", "x", "$1$abc$def", "plain text"})
    EXPECT_FALSE(fits("plain text", text)) << text;
  EXPECT_FALSE(fits(std::string("a\0b", 3), hash_of("12345678")));
}

TEST(Password, TooShortTooLongAndControlCharactersAreRefused) {
  EXPECT_THROW(hash_of("1234567"), Error);
  EXPECT_THROW(hash_of(std::string(kMostPassword + 1, 'x')), Error);
  EXPECT_THROW(hash_of("1234567\n8"), Error);
  EXPECT_NO_THROW(hash_of("contraseña larga"));
}

}  // namespace
}  // namespace polyarm::users
