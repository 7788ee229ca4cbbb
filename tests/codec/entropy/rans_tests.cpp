#include "codec/entropy/rans.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

/// Numbers of plain bits, from the least number of each token to that of the next.
std::uint64_t first_of(unsigned token) {
  std::uint64_t first = 0;
  for (unsigned t = 0; t < token; ++t) first += std::uint64_t{1} << plain_bits(t);
  return first;
}

std::vector<std::int64_t> telling_residuals() {
  std::vector<std::int64_t> residuals;
  for (std::int64_t r = -70'000; r <= 70'000; ++r) residuals.push_back(r);
  for (int exponent = 16; exponent <= 32; ++exponent) {
    for (const std::int64_t off : {-3, -2, -1, 0, 1, 2, 3}) {
      for (const std::int64_t part : {4, 5, 6, 7}) {
        const std::int64_t size = (std::int64_t{part} << exponent) / 4 + off;
        if (size >= std::int64_t{1} << 32) continue;
        residuals.push_back(size);
        residuals.push_back(-size - 1);
      }
    }
  }
  residuals.push_back((std::int64_t{1} << 32) - 1);
  residuals.push_back(-(std::int64_t{1} << 32));
  return residuals;
}

TEST(Token, GivesBackEveryResidualOf33Bits) {
  for (const std::int64_t residual : telling_residuals()) {
    const Token token = token_of(residual);
    ASSERT_LT(token.index, Token::kCount) << residual;
    ASSERT_EQ(token.bit_count, plain_bits(token.index)) << residual;
    ASSERT_LT(token.bits, std::uint64_t{1} << token.bit_count) << residual;
    ASSERT_EQ(residual_of(token.index, token.bits), residual);
  }
}

TEST(Token, StandsForTheNumbersOfTheSpecification) {
  for (const std::int64_t residual : telling_residuals()) {
    const Token token = token_of(residual);
    const std::uint64_t z =
        residual >= 0 ? 2 * static_cast<std::uint64_t>(residual) : 2 * static_cast<std::uint64_t>(-residual) - 1;
    if (token.index < 16) {
      ASSERT_EQ(z, token.index);
      continue;
    }
    const unsigned e = 4 + (token.index - 16) / 2;
    ASSERT_EQ(token.bit_count, e - 1);
    ASSERT_EQ(z, (std::uint64_t{1} << e) + ((token.index - 16) % 2) * (std::uint64_t{1} << (e - 1)) + token.bits);
  }
}

TEST(Token, CoversAllNumbersWithoutAGap) {
  for (unsigned t = 0; t < Token::kCount; ++t) {
    const std::uint64_t last = (std::uint64_t{1} << plain_bits(t)) - 1;
    EXPECT_EQ(token_of(residual_of(t, 0)).index, t);
    EXPECT_EQ(token_of(residual_of(t, last)).index, t);
    const std::int64_t next = residual_of(t, last);
    const std::uint64_t z =
        next >= 0 ? 2 * static_cast<std::uint64_t>(next) : 2 * static_cast<std::uint64_t>(-next) - 1;
    EXPECT_EQ(z + 1, first_of(t + 1)) << t;
  }
  EXPECT_EQ(first_of(Token::kCount), std::uint64_t{1} << 33);
}

TEST(Distribution, GivesEveryTokenAFrequencyAndAllOfThemTheWhole) {
  for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
    for (unsigned count = Token::kDirect; count <= Token::kCount; ++count) {
      const Distribution distribution = make_distribution(number, count);
      std::uint32_t next = 0;
      for (unsigned t = 0; t < count; ++t) {
        ASSERT_GE(distribution.frequency[t], 1) << number << ", " << t << " of " << count;
        ASSERT_EQ(distribution.start[t], next);
        next += distribution.frequency[t];
      }
      ASSERT_EQ(next, kProbabilityOne) << number << ", " << count << " tokens";
      for (unsigned t = count; t < Token::kCount; ++t) ASSERT_EQ(distribution.frequency[t], 0);
    }
  }
}

TEST(Distribution, HasTheShapesOfTheSpecification) {
  for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
    for (const unsigned count : {16U, 33U, 74U}) {
      const long double width = 0.25L * std::pow(2.0L, static_cast<long double>(number / 2) / 2);
      std::vector<long double> weight(count);
      long double sum = 0;
      for (unsigned t = 0; t < count; ++t) {
        const auto size = static_cast<long double>(std::uint64_t{1} << plain_bits(t));
        const std::uint64_t m = (first_of(t) + (std::uint64_t{1} << plain_bits(t)) / 2 + 1) / 2;
        const auto middle = static_cast<long double>(m);
        const long double density = number % 2 == 0 ? std::pow(width / (width + 1), middle)
                                                    : std::pow(1 + middle * middle / (width * width), -2.0L);
        weight[t] = size * density;
        sum += weight[t];
      }
      const Distribution distribution = make_distribution(number, count);
      const auto* greatest = std::max_element(distribution.frequency.begin(), distribution.frequency.end());
      for (unsigned t = 0; t < count; ++t) {
        const long double expected = 1 + std::floor(weight[t] / sum * (kProbabilityOne - count));
        const bool filled_up = &distribution.frequency[t] == greatest;
        EXPECT_NEAR(distribution.frequency[t], static_cast<double>(expected), filled_up ? count : 1)
            << number << ", " << t << " of " << count;
      }
    }
  }
}

TEST(SymbolTable, FindsTheTokenOfEveryPlace) {
  for (const unsigned number : {0U, 1U, 20U, 51U, 111U}) {
    for (const unsigned count : {16U, 40U, 74U}) {
      const Distribution distribution = make_distribution(number, count);
      const SymbolTable table = make_symbol_table(distribution, count);
      for (std::uint32_t place = 0; place < kProbabilityOne; ++place) {
        const unsigned t = table[place];
        ASSERT_LT(t, count);
        ASSERT_LE(distribution.start[t], place);
        ASSERT_LT(place, std::uint32_t{distribution.start[t]} + distribution.frequency[t]);
      }
    }
  }
}

TEST(Cost, IsTheLogarithmWithinA128thOfABit) {
  for (std::uint32_t frequency = 1; frequency <= kProbabilityOne; ++frequency) {
    const double bits = std::log2(static_cast<double>(kProbabilityOne) / frequency);
    ASSERT_NEAR(cost_256(frequency) / 256.0, bits, 1.0 / 128) << frequency;
  }
  EXPECT_EQ(cost_256(kProbabilityOne), 0U);
  EXPECT_EQ(cost_256(1), 12U * 256U);
}

/// Something that goes into a stream.
struct Piece {
  std::uint32_t start = 0;
  std::uint32_t frequency = 0;  ///< 0: plain bits
  std::uint64_t bits = 0;
  unsigned bit_count = 0;
};

/// Tokens, flags and plain bits of all sizes, and how many bits they should take.
struct Message {
  std::vector<Piece> pieces;
  double bit_count = 0;
};
Message random_message(std::uint64_t seed, std::size_t count) {
  std::mt19937_64 random(seed);
  const Distribution distribution = make_distribution(static_cast<unsigned>(random() % 112), 40);
  const SymbolTable symbols = make_symbol_table(distribution, 40);
  Message message;
  for (std::size_t k = 0; k < count; ++k) {
    Piece piece;
    switch (random() % 3) {
      case 0: {
        const unsigned token =
            random() % 2 == 0 ? symbols[random() % kProbabilityOne] : static_cast<unsigned>(random() % 40);
        piece.start = distribution.start[token];
        piece.frequency = distribution.frequency[token];
        break;
      }
      case 1: {
        const std::uint32_t yes = 16 * (1 + static_cast<std::uint32_t>(random() % 255));
        const bool value = random() % kProbabilityOne < yes;
        piece.start = value ? 0 : yes;
        piece.frequency = value ? yes : kProbabilityOne - yes;
        break;
      }
      default:
        piece.bit_count = static_cast<unsigned>(random() % 41);
        piece.bits = random() & ((std::uint64_t{1} << piece.bit_count) - 1);
    }
    message.bit_count +=
        piece.frequency == 0 ? piece.bit_count : std::log2(static_cast<double>(kProbabilityOne) / piece.frequency);
    message.pieces.push_back(piece);
  }
  return message;
}

Bytes encode(const std::vector<Piece>& pieces) {
  RansEncoder out;
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) {
    piece->frequency == 0 ? out.put_bits(piece->bits, piece->bit_count) : out.put(piece->start, piece->frequency);
  }
  return out.finish();
}

/// Reads what should be there; how much of it was. From a heap block of exactly the size of the stream.
struct Reading {
  std::size_t right = 0;
  bool at_end = false;
};
Reading decode(std::span<const std::byte> stream, const std::vector<Piece>& pieces) {
  const auto copy = std::make_unique<std::byte[]>(stream.size());
  std::copy(stream.begin(), stream.end(), copy.get());
  RansDecoder in({copy.get(), stream.size()});
  Reading reading;
  for (const Piece& piece : pieces) {
    if (piece.frequency == 0) {
      reading.right += in.bits(piece.bit_count) == piece.bits ? 1 : 0;
      continue;
    }
    reading.right += in.peek() >= piece.start && in.peek() < piece.start + piece.frequency ? 1 : 0;
    if (in.peek() < piece.start) return reading;  // what a reader would take for another symbol
    in.take(piece.start, piece.frequency);
  }
  reading.at_end = in.at_end();
  return reading;
}

TEST(Rans, GivesBackTokensFlagsAndPlainBits) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Message message = random_message(seed, 20 * seed);
    const Bytes stream = encode(message.pieces);
    const Reading reading = decode(stream, message.pieces);
    EXPECT_EQ(reading.right, message.pieces.size()) << seed;
    EXPECT_TRUE(reading.at_end) << seed;
  }
}

TEST(Rans, GivesBackSymbolsThatTakeTheStateExactlyToItsLimits) {
  for (unsigned a = 0; a <= 12; ++a) {
    for (unsigned b = 0; b <= 12; ++b) {
      for (unsigned c = 0; c <= 12; ++c) {
        std::vector<Piece> pieces;
        for (const unsigned count : {a, b, c}) pieces.push_back({.bit_count = count});
        const Reading reading = decode(encode(pieces), pieces);
        EXPECT_EQ(reading.right, 3U) << a << ' ' << b << ' ' << c;
        EXPECT_TRUE(reading.at_end) << a << ' ' << b << ' ' << c;
      }
    }
  }
}

TEST(Rans, TakesHardlyMoreThanTheProbabilitiesAskFor) {
  const Message message = random_message(5, 20'000);
  const auto size = static_cast<double>(encode(message.pieces).size());
  EXPECT_GE(size, message.bit_count / 8);
  EXPECT_LE(size, 1.001 * message.bit_count / 8 + 6);
}

TEST(Rans, LaysOutAStreamAsTheSpecificationSays) {
  EXPECT_EQ(encode({}), (Bytes{std::byte{0}, std::byte{0}, std::byte{1}, std::byte{0}}));
  const Message message = random_message(9, 500);
  const Bytes stream = encode(message.pieces);
  ASSERT_EQ(stream.size() % 2, 0U);
  std::size_t next = 0;
  const auto word = [&] {
    const auto low = std::to_integer<std::uint64_t>(stream.at(next));
    const auto high = std::to_integer<std::uint64_t>(stream.at(next + 1));
    next += 2;
    return low + 256 * high;
  };
  std::uint64_t state = word();
  state += 65536 * word();
  EXPECT_GE(state, 65536U);
  const auto take = [&](std::uint64_t start, std::uint64_t frequency) {
    const std::uint64_t s = state % 4096;
    ASSERT_TRUE(s >= start && s < start + frequency);
    state = frequency * (state / 4096) + s - start;
    if (state < 65536) state = 65536 * state + word();
    ASSERT_LT(state, std::uint64_t{1} << 32);
  };
  for (const Piece& piece : message.pieces) {
    if (piece.frequency != 0) {
      take(piece.start, piece.frequency);
      continue;
    }
    for (unsigned from = 0; from < piece.bit_count; from += 12) {
      const unsigned k = std::min(12U, piece.bit_count - from);
      const std::uint64_t v = (piece.bits >> from) % (std::uint64_t{1} << k);
      take(v << (12 - k), std::uint64_t{1} << (12 - k));
    }
  }
  EXPECT_EQ(next, stream.size());
  EXPECT_EQ(state, 65536U);
}

TEST(Rans, IsNotAtItsEndWhenTruncated) {
  const Message message = random_message(3, 300);
  const Bytes stream = encode(message.pieces);
  for (std::size_t size = 0; size < stream.size(); ++size) {
    EXPECT_FALSE(decode(std::span(stream).first(size), message.pieces).at_end) << size;
  }
}

TEST(Rans, IsNotAtItsEndBeforeTheLastSymbolOrBehindIt) {
  const Message message = random_message(4, 300);
  const Bytes stream = encode(message.pieces);
  for (std::size_t count = 0; count < message.pieces.size(); ++count) {
    const auto tail = message.pieces.begin() + static_cast<std::ptrdiff_t>(count);
    const bool nothing_left = std::all_of(
        tail, message.pieces.end(), [](const Piece& piece) { return piece.frequency == 0 && piece.bit_count == 0; });
    const std::vector<Piece> first(message.pieces.begin(), tail);
    EXPECT_EQ(decode(stream, first).at_end, nothing_left) << count;
  }
  RansDecoder in(stream);
  for (const Piece& piece : message.pieces) {
    if (piece.frequency == 0) {
      EXPECT_EQ(in.bits(piece.bit_count), piece.bits);
    } else {
      in.take(piece.start, piece.frequency);
    }
  }
  EXPECT_TRUE(in.at_end());
  EXPECT_EQ(in.bits(40), 0U);  // the state that encoders begin with, then nothing
  EXPECT_FALSE(in.at_end());
  EXPECT_TRUE(in.overrun());
}

TEST(Rans, IsNotAtItsEndWithMoreBytes) {
  const Message message = random_message(6, 300);
  Bytes stream = encode(message.pieces);
  for (int more = 1; more <= 6; ++more) {
    stream.push_back(std::byte{0});
    const Reading reading = decode(stream, message.pieces);
    EXPECT_EQ(reading.right, message.pieces.size());
    EXPECT_FALSE(reading.at_end) << more;
  }
}

TEST(Rans, SurvivesEveryFlippedBit) {
  const Message message = random_message(8, 100);
  Bytes stream = encode(message.pieces);
  for (std::size_t bit = 0; bit < 8 * stream.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    stream[bit / 8] ^= mask;
    const Reading reading = decode(stream, message.pieces);
    EXPECT_FALSE(reading.at_end && reading.right == message.pieces.size()) << bit;
    stream[bit / 8] ^= mask;
  }
}

TEST(Rans, RefusesAFirstStateThatNoEncoderLeaves) {
  for (const std::uint32_t state : {0U, 1U, 0xFFFFU, 0x10000U}) {
    Bytes stream(4);
    std::memcpy(stream.data(), &state, 4);
    const RansDecoder in(stream);
    EXPECT_EQ(in.overrun(), state < 0x10000U);
    EXPECT_EQ(in.at_end(), state == 0x10000U);
  }
}

}  // namespace
}  // namespace sbrdf::internal
