#pragma once

// The front door of libsbrdf: everything that a program needs to open, evaluate, convert and save a measured BRDF.
//
//   #include <sbrdf/sbrdf.h>
//   const auto material = sbrdf::Material::open("leather.sbrdf");
//   if (!material) return fail(material.error().message);
//   std::vector<float> f_r(material->channel_count());
//   material->evaluate(sbrdf::pair_from_degrees(30, 0, 45, 180), f_r);
//
// Nothing here prints, and nothing throws but for lack of memory, or what a callback throws. Link with sbrdf::sbrdf
// (CMake) or `pkg-config --cflags --libs sbrdf`.
//
// Some damaged HDF5 files bring down the library that reads them, and the process with it. The program `sbrdf` tries
// each in a process of its own first; this library starts none.

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#if defined(__GNUC__)
#define SBRDF_API __attribute__((visibility("default")))
#else
#define SBRDF_API
#endif

namespace sbrdf {

/// What went wrong, by who can mend it. The numbers are the exit codes of the program `sbrdf`.
enum class ErrorCode : std::uint8_t {
  kUsage = 1,        ///< an option or a parameter is out of its range
  kIo = 2,           ///< the operating system, or a callback, refused to read or write; or a callback asked to stop
  kInvalidFile = 3,  ///< the bytes are no valid file, or hold values that cannot be a BRDF
  kUnsupported = 4,  ///< valid, but of a kind that is not handled
  kDifference = 5,   ///< an error is above the target that was asked for
};

/// A failure. `message` is one line of UTF-8 without the file's name; `offset` is the place in the file [bytes from its
/// start], where there is one. Messages about .sbrdf files begin with the rule of specs/sbrdf.md that is broken, as in
/// "[SB-1-6]".
struct Error {
  ErrorCode code = ErrorCode::kInvalidFile;
  std::string message;
  std::optional<std::uint64_t> offset = {};
};

/// A value or an Error, which `if (result)` tells apart. Asking for the one that is not there is a bug of the caller.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  [[nodiscard]] const Error& error() const {
    assert(!*this);
    return *std::get_if<1>(&state_);
  }
  T& operator*() & { return *operator->(); }
  const T& operator*() const& { return *operator->(); }
  T&& operator*() && { return std::move(*operator->()); }
  T* operator->() {
    assert(*this);
    return std::get_if<0>(&state_);
  }
  const T* operator->() const {
    assert(*this);
    return std::get_if<0>(&state_);
  }

 private:
  std::variant<T, Error> state_;
};

/// A direction on the upper hemisphere [radians]: `theta` from the normal (+z), `phi` from the tangent (+x) towards +y.
struct Direction {
  double theta = 0;
  double phi = 0;
};

/// Directions to the light (`i`) and to the viewer (`v`), both pointing away from the surface.
struct DirectionPair {
  Direction i;
  Direction v;
};

/// A pair from degrees, as files and the command line have them.
[[nodiscard]] SBRDF_API DirectionPair pair_from_degrees(double theta_i_deg, double phi_i_deg, double theta_v_deg,
                                                        double phi_v_deg);

/// Something noted about the data when it was read: "cells with some negative channel", 12 of 1,458,000.
struct Finding {
  std::string what;  ///< in the plural
  std::uint64_t count = 0;
  std::uint64_t total = 0;
};

/// What holds for a material as a whole.
struct Traits {
  std::string format;                 ///< "sbrdf", "merl", "rgl", "kurt", ...: as `sbrdf formats` lists them
  std::string description;            ///< one line for people
  std::vector<std::string> channels;  ///< names in the order of the values, such as R, G, B
  bool isotropic = false;             ///< values depend on phi_i - phi_v only
  bool reciprocal = false;            ///< f(i,v) = f(v,i) by construction
  std::vector<Finding> findings;
};

/// Options of a format, by name and as text, exactly as on the command line without the dashes:
/// {{"samples", "3000"}, {"precision", "0.1%"}}; a flag has the text "". `sbrdf formats` lists what each format takes;
/// a name that it does not know, or a value out of range, is kUsage.
using Options = std::map<std::string, std::string>;

/// Bytes at an offset into `target`, which is filled to its end, or an error. May be called from several threads at
/// once, but only during the call that it is given to. Must not be empty.
using ReadRange = std::function<std::optional<Error>(std::uint64_t offset, std::span<std::byte> target)>;

/// Told the fraction done, in (0, 1] and rising, from any thread but never from two at once. Returning false stops the
/// work, which then fails with kIo and leaves nothing behind. Must not call this library.
using Progress = std::function<bool(double fraction)>;

/// What of a material to load; whole cells around it are. Formats that cannot be read in part (all but .sbrdf) refuse
/// one with kUnsupported.
struct Part {
  /// Both directions no further from the normal than this [degrees].
  double theta_max_deg = 90;
  /// Level of detail: samples that came from halving the gaps between crossings more often than this are left out. 0 is
  /// the crossings alone, 16 is everything.
  int level = 16;
  /// Only what these pairs need, beside the two limits above; empty: everything.
  std::vector<DirectionPair> pairs = {};
};

struct OpenOptions {
  std::optional<Part> part = {};  ///< not given: the whole material
  Options format = {};            ///< options of the format that is found
  /// What an .sbrdf or a bundle may make the library allocate, at most [bytes]; kUnsupported beyond. Not given: 64 MiB
  /// and 1024 bytes for each byte of the file, which no honest one needs.
  std::optional<std::uint64_t> memory_limit = {};
};

/// Something that a conversion changed or lost, for people (`text`) and for scripts (`key`, `value`).
struct Remark {
  std::string key;  ///< such as "negative_values"
  double value = 0;
  std::string text;
};

/// What was written.
struct Report {
  std::string format;
  std::uint64_t bytes = 0;
  std::vector<Remark> remarks;
};

struct SavedBytes {
  std::vector<std::byte> bytes;
  Report report;
};

struct SaveOptions {
  Options format = {};     ///< options of the format that is written
  Progress progress = {};  ///< may be empty
};

/// A direction to the viewer that was drawn for one to the light.
struct Sample {
  std::array<float, 3> w_v = {0, 0, 1};  ///< unit vector above the horizon
  /// The density that it was drawn with [1/sr, by solid angle]; 0 where nothing could be drawn.
  float pdf = 0;
};

/// How a material that consists of slices is evaluated for vectors.
enum class Form : std::uint8_t {
  kExact,       ///< splines, as the file says
  kPresampled,  ///< straight between close places: no slice is off by more than 0.0005 of its value; some times as
                ///< large
  kDense,  ///< one table of up to 8 MiB, isotropic materials only: fastest, some tenths of a percent off on average
};

/// A BRDF that can be evaluated, whatever it was read from. A handle: copies share what they hold. Immutable, so that
/// one object serves any number of threads.
class SBRDF_API Material {
 public:
  /// `name` is a file of any readable format, recognised by its content; BUNDLE.sbrdfz:NAME; kurt:NAME, one of the
  /// built-in analytic materials; or kurt:FILE.json. A file whose own name begins so is
  /// "./kurt:...". Files above 64 MiB, bundles and those of which a part is loaded are read in place, as far as they
  /// are needed: they must not become shorter while the material lives. Others are read at once.
  ///
  /// Errors: kIo where it cannot be read, kInvalidFile, kUnsupported, kUsage for options.
  static Result<Material> open(const std::string& name, const OpenOptions& options = {});

  /// The same from bytes in memory.
  static Result<Material> open(std::vector<std::byte> bytes, const OpenOptions& options = {});

  /// The same from anything that can be read a range at a time, such as a file behind a network. `size` is that of the
  /// whole [bytes]. An .sbrdf asks for its head and then for the chunks that `options.part` needs.
  static Result<Material> open(std::uint64_t size, ReadRange read, const OpenOptions& options = {});

  /// The first call may look at a whole file, for its findings.
  [[nodiscard]] const Traits& traits() const;
  [[nodiscard]] std::size_t channel_count() const;

  /// How the file came to be, and its error: a JSON object, or empty where the format holds none.
  [[nodiscard]] const std::string& metadata() const;

  /// f_r [1/sr], without any cosine, of one pair; `values` has one entry per channel. Below the horizon (theta beyond
  /// pi/2, or angles that are not finite) 0, always. Finite everywhere else, but for a Part: NaN for pairs that it does
  /// not cover.
  void evaluate(const DirectionPair& pair, std::span<float> values) const;

  /// The same for many; `values` has pairs.size() x channel_count() entries, channel fastest. Spread over all cores
  /// where there is work enough; the same bits as one by one.
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const;

  /// The same for vectors x, y, z with the normal at (0, 0, 1), which need not be normalised exactly. `w_i` and `w_v`
  /// have the same length. For a whole .sbrdf this is the fastest way; values agree with those of angles to rounding.
  void evaluate(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 3>> w_v,
                std::span<float> values) const;

  /// The same material in another form, which is made now, for those who ask for many values. `evaluate` for vectors
  /// and `sample` use it; `evaluate` for angles, and what is saved, stay exact. How far the dense form of a material is
  /// off, nothing bounds: `sbrdf bench` measures it.
  ///
  /// Errors: kUnsupported for what does not consist of slices, such as a Part, and for the dense form of a material
  /// that is anisotropic, or whose nodes alone take more than 8 MiB.
  [[nodiscard]] Result<Material> in_form(Form form) const;

  /// Draws a direction to the viewer about as densely as f_r cos theta_v is large, and evaluates there: the mean of
  /// `values * sample.w_v[2] / sample.pdf` over uniform `u` is the share of the light from `w_i` that is sent back.
  /// `u` are two numbers in [0, 1), beyond which the nearest that is counts; like ones give like directions, so that
  /// stratified ones stay so. `values` has one entry per channel: f_r [1/sr], the bits of `evaluate`. The same input
  /// gives the same bits on any thread. `w_i` is a vector x, y, z above the horizon of any length; on it or below, or
  /// where a number is not finite, the sample has the density 0 and the values are 0.
  ///
  /// Where the light is to be drawn for a viewer, exchange the two, if the material is reciprocal. Of several channels
  /// the mean is what counts, and values below zero count as 0: they are seldom drawn, but returned as they are.
  ///
  /// The first call of one of those below makes a table for it, from some 40,000 pairs, or up to 220,000 for what is
  /// not isotropic; it takes at most 256 KiB, or 1 MiB. Of a Part those pairs that it does not cover count as 0 there;
  /// where one is drawn nevertheless, its values are NaN.
  Sample sample(const std::array<float, 3>& w_i, const std::array<float, 2>& u, std::span<float> values) const;

  /// The same for angles; what is drawn is a vector nevertheless.
  Sample sample(const Direction& i, const std::array<float, 2>& u, std::span<float> values) const;

  /// The same for many; `w_i`, `u` and `samples` have the same length, `values` samples.size() x channel_count()
  /// entries, channel fastest. Spread over all cores; the same bits as one by one.
  void sample(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 2>> u,
              std::span<Sample> samples, std::span<float> values) const;

  /// The density [1/sr, by solid angle] with which `sample` draws `w_v` for `w_i`: of a direction that it drew, the
  /// bits that it told. Its integral over the directions above the horizon is 1, and it is above 0 on all of them. 0
  /// where one of both is on the horizon or below, or not finite. Vectors of any length but 0.
  [[nodiscard]] float pdf(const std::array<float, 3>& w_i, const std::array<float, 3>& w_v) const;

  /// The same for angles, brought into vectors of float32 first.
  [[nodiscard]] float pdf(const DirectionPair& pair) const;

  /// Of pairs above the horizon: false only for a Part and a pair outside of it.
  [[nodiscard]] bool covers(const DirectionPair& pair) const;

  /// Writes the material in the format of the extension of `path`. The file is complete or untouched: bytes go to a
  /// temporary one in the same folder, which takes its place at the end. A material that was read from the same format
  /// is copied without sampling it again, unless options ask for it.
  ///
  /// Errors: kUsage for an extension that no writable format has, or for options; kUnsupported for a Part, and for a
  /// material that the format cannot hold; kInvalidFile where it gives values that are no reflectance; kIo; kDifference
  /// where a target cannot be reached.
  [[nodiscard]] Result<Report> save(const std::string& path, const SaveOptions& options = {}) const;

  /// The same into memory; `extension` such as ".sbrdf".
  [[nodiscard]] Result<SavedBytes> save_to_memory(std::string_view extension, const SaveOptions& options = {}) const;

 private:
  struct State;
  explicit Material(std::shared_ptr<const State> state);

  std::shared_ptr<const State> state_;
};

/// Of the library that is linked, such as "0.1.0".
[[nodiscard]] SBRDF_API const char* version();

}  // namespace sbrdf
