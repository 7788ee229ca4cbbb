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

DecodingTables::DecodingTables(const Distributions& distributions) {
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    const unsigned number = distributions.number(static_cast<unsigned>(k));
    residuals[k].distribution = make_distribution(number, distributions.token_count);
    residuals[k].symbols = make_symbol_table(residuals[k].distribution, distributions.token_count);
  }
  for (std::size_t k = 0; k < flags.size(); ++k) flags[k] = kFlagUnit * distributions.flags[k];
}

}  // namespace sbrdf::internal
