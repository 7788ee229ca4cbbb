#include "formats/table/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using Bytes = std::vector<std::byte>;

Bytes npy(std::string_view dictionary, std::size_t data_size, std::uint8_t major = 1, std::uint8_t minor = 0) {
  std::string text = "\x93NUMPY";
  text += static_cast<char>(major);
  text += static_cast<char>(minor);
  for (int k = 0; k < (major == 1 ? 2 : 4); ++k) text += static_cast<char>(dictionary.size() >> (8 * k) & 0xFF);
  text += dictionary;
  text.append(data_size, '\1');
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

Result<NpyHeader> parse(const Bytes& bytes) { return parse_npy_header(bytes, bytes.size()); }

TEST(NpyHeaderParse, ReadsWhatNumPyWrites) {
  for (const std::uint8_t major : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}}) {
    const auto header =
        parse(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 1, 4, 5), }   \n", 480, major));
    ASSERT_TRUE(header.ok()) << header.error().message;
    EXPECT_EQ(header->number_size, 4U);
    EXPECT_FALSE(header->fortran_order);
    EXPECT_THAT(header->shape, ElementsAre(2, 3, 1, 4, 5));
    EXPECT_EQ(header->number_count(), 120U);
    EXPECT_EQ(header->data_offset, (major == 1 ? 10U : 12U) + 72U);
  }
}

TEST(NpyHeaderParse, ReadsAnyOrderQuotesAndBlanks) {
  const auto header = parse(npy("  {\"shape\":(7L,),'fortran_order' : True,\n\t'descr':\"<f2\"}", 14));
  ASSERT_TRUE(header.ok()) << header.error().message;
  EXPECT_EQ(header->number_size, 2U);
  EXPECT_TRUE(header->fortran_order);
  EXPECT_THAT(header->shape, ElementsAre(7));
  EXPECT_TRUE(parse(npy("{'shape':(),'fortran_order':False,'descr':'<f8'}", 8)).ok());
  EXPECT_TRUE(parse(npy("{'shape':(0,9),'fortran_order':False,'descr':'<f8'}", 0)).ok());
}

TEST(NpyHeaderParse, NamesWhatItDoesNotRead) {
  const auto with_type = [](std::string_view type) {
    return parse(npy("{'descr': " + std::string(type) + ", 'fortran_order': False, 'shape': (1,)}", 8)).error();
  };
  EXPECT_THAT(with_type("'>f4'").message, HasSubstr("big-endian"));
  EXPECT_THAT(with_type("'|O'").message, HasSubstr("pickled"));
  EXPECT_THAT(with_type("'<i8'").message, HasSubstr("'<i8'"));
  EXPECT_THAT(with_type("[('a', '<f4')]").message, HasSubstr("records"));
  for (const char* type : {"'>f8'", "'|O'", "'<c16'", "'\x01\xFF'", "[]"}) {
    EXPECT_EQ(with_type(type).code, ErrorCode::kUnsupported) << type;
  }
  const auto newer = parse(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1,)}", 4, 4));
  EXPECT_THAT(newer.error().message, HasSubstr("version 4.0"));
  const auto longer = parse(npy(std::string(70000, ' '), 4, 2));
  EXPECT_EQ(longer.error().code, ErrorCode::kUnsupported);
}

TEST(NpyHeaderParse, EvaluatesNothing) {
  for (const char* dictionary :
       {"", "{", "{}", "{'descr'}", "{'descr': '<f4'}", "{'descr': '<f4', 'fortran_order': False, 'shape': (1,)} x",
        "{'descr': '<f4', 'fortran_order': False, 'shape': [1]}", "{'descr': '<f4', 'fortran_order': 0, 'shape': (1,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1+0,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'shape': (1,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'x': 1}",
        "{'descr': __import__('os'), 'fortran_order': False, 'shape': (1,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1,"}) {
    const auto header = parse(npy(dictionary, 4));
    ASSERT_FALSE(header.ok()) << dictionary;
    EXPECT_EQ(header.error().code, ErrorCode::kInvalidFile) << dictionary;
  }
}

TEST(NpyHeaderParse, RefusesSizesThatOnlyMatchWrapped) {
  const auto header = parse(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (4294967296, 4294967296, 4)}", 0));
  ASSERT_FALSE(header.ok());
  EXPECT_THAT(header.error().message, HasSubstr("more than 2^64"));
}

TEST(NpyHeaderParse, RefusesEveryTruncationAndAnyByteMore) {
  const std::vector<std::uint64_t> shape = {2, 1, 1, 1, 3};
  Bytes file = emit_npy_header(4, shape);
  file.resize(file.size() + 24);
  ASSERT_TRUE(parse(file).ok());
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_FALSE(parse(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size))).ok()) << size;
  }
  file.push_back({});
  EXPECT_THAT(parse(file).error().message, HasSubstr("after the end"));
}

TEST(NpyHeaderEmit, IsAsNumPyWritesIt) {
  const std::vector<std::uint64_t> shape = {2, 3, 4, 5, 1};
  const Bytes header = emit_npy_header(8, shape);
  EXPECT_EQ(header.size() % 64, 0U);
  const std::string text(reinterpret_cast<const char*>(header.data()), header.size());
  EXPECT_THAT(text, HasSubstr("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3, 4, 5, 1), }"));
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace sbrdf::internal
