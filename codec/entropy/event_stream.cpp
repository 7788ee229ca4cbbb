#include "codec/entropy/event_stream.h"

namespace sbrdf::internal {
namespace {

// Flags are stored in 1/256, the coder counts in 1/4096.
constexpr std::uint32_t kFlagUnit = kProbabilityOne / 256;

}  // namespace

StreamWriter::StreamWriter(const Distributions& distributions) {
  for (std::size_t k = 0; k < residuals_.size(); ++k) {
    residuals_[k] = make_distribution(distributions.number(static_cast<unsigned>(k)), distributions.token_count);
  }
  for (std::size_t k = 0; k < flags_.size(); ++k) flags_[k] = kFlagUnit * distributions.flags[k];
}

std::vector<std::byte> StreamWriter::write(std::span<const Event> events) const {
  if (events.empty()) return {};
  RansEncoder out;
  for (auto event = events.rbegin(); event != events.rend(); ++event) put(*event, out);
  return out.finish();
}

// What is read first goes in last: the plain bits before their token.
void StreamWriter::put(const Event& event, RansEncoder& out) const {
  if (event.flag) {
    const std::uint32_t yes = flags_[event.context];
    event.value != 0 ? out.put(0, yes) : out.put(yes, kProbabilityOne - yes);
    return;
  }
  const Token token = token_of(event.value);
  const Distribution& distribution = residuals_[event.context];
  out.put_bits(token.bits, token.bit_count);
  out.put(distribution.start[token.index], distribution.frequency[token.index]);
}

DecodingTables::DecodingTables(const Distributions& distributions)
    : distributions_(distributions),
      residuals_(std::make_unique_for_overwrite<Residuals[]>(CodingContext::kResidualCount)) {
  for (std::size_t k = 0; k < flags_.size(); ++k) flags_[k] = kFlagUnit * distributions.flags[k];
}

void DecodingTables::make(unsigned context) {
  const unsigned tokens = distributions_.token_count;
  const Distribution distribution = make_distribution(distributions_.number(context), tokens);
  Residuals& made = residuals_[context];
  for (unsigned t = 0; t < Token::kCount; ++t) {
    made.ranges[t] = distribution.start[t] | std::uint32_t{distribution.frequency[t]} << 16U;
  }
  made.symbols = make_symbol_table(distribution, tokens);
  made_[context] = true;
}

}  // namespace sbrdf::internal
