#include "capture/stream/stream_output.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "capture/stream/stream_grid.h"
#include "capture/stream/stream_sink.h"
#include "capture/studio_clock.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

using Kind = StreamAddress::Kind;

constexpr std::size_t kMostLatencies = 100'000;
constexpr auto kCallAgain = std::chrono::seconds(1);
constexpr auto kLookAround = std::chrono::milliseconds(100);

// Studio time is the steady clock's (studio_clock.h).
std::chrono::steady_clock::time_point steady(Timestamp t) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(t.ns));
}

StreamFormat format_of(const StreamOptions& o) {
  return {o.width + o.width % 2, o.height + o.height % 2, o.rate, o.most_kbit};
}

// Whoever hears the network sees the pictures: said like the page says it.
Result<void> warn_beyond_this_machine(const StreamAddress& a) {
  if (a.kind == Kind::File || a.kind == Kind::V4l2) return {};
  const Result<bool> here = is_loopback(a);
  if (!here) return forward(here);
  if (*here || a.encrypted) return {};
  log::warning(
      text("the stream ", a.shown, a.listens ? " listens beyond this machine" : " leaves this machine",
           " and is not encrypted: ",
           a.listens ? "whoever reaches the port gets the pictures" : "whoever hears the network sees it",
           "; use a network of the studio's own, 127.0.0.1, or srt with passphrase="));
  return {};
}

}  // namespace

struct StreamOutput::Impl {
  Impl(StreamAddress a, const StreamOptions& o) : address(std::move(a)), options(o), grid(o.rate) {}

  ~Impl() {
    {
      std::lock_guard lock(mutex);
      ending = true;
    }
    wake.notify_all();
    if (thread.joinable()) thread.join();
  }

  bool over() const { return ending || (options.stop && options.stop()); }

  Result<void> open() {
    const auto stop = [this] { return over(); };
    Result<std::unique_ptr<StreamSink>> made = address.kind == Kind::V4l2
                                                   ? open_v4l2_sink(address, format_of(options), stop)
                                                   : open_coded_sink(address, format_of(options), stop);
    if (!made) return forward(made);
    sink = std::move(*made);
    if (!address.listens) {
      if (Result<void> ok = sink->connect(); !ok) return ok;
      receiver_came();
    }
    thread = std::thread([this] { run(); });
    return {};
  }

  void receiver_came() {
    std::lock_guard lock(mutex);
    ++counts.receivers;
    counts.connected = true;
    counts.trouble.clear();
    fresh_receiver = true;
    exposed.reset();  // what has waited for the receiver says nothing of the way to it
    grid.resume(studio_now());
    if (address.listens || counts.receivers > 1)
      log::info(text("stream ", address.shown, ": a receiver is there"));
  }

  void receiver_went(const std::string& why) {
    sink->close();
    std::lock_guard lock(mutex);
    if (counts.connected) log::warning(text(why, sink->returns() ? "; waiting for one" : ""));
    counts.connected = false;
    counts.trouble = why;
  }

  void run() {
    std::unique_lock lock(mutex);
    while (!ending) {
      if (!counts.connected) {
        lock.unlock();
        const Result<void> connected = connect_again();
        lock.lock();
        if (!connected) wake.wait_for(lock, kCallAgain, [this] { return ending.load(); });
        continue;
      }
      const std::optional<StreamGrid::Due> due = grid.due(studio_now(), fresh);
      if (due) {
        send(lock, *due);
        continue;
      }
      const std::optional<Timestamp> next = grid.next(fresh);
      const auto latest = std::chrono::steady_clock::now() + kLookAround;
      wake.wait_until(lock, next ? std::min(steady(*next), latest) : latest);
    }
    lock.unlock();
    sink->close();
  }

  Result<void> connect_again() {
    Result<void> connected = sink->returns() ? sink->connect() : fail(ErrorCode::Io, counts.trouble);
    if (connected)
      receiver_came();
    else if (!over())
      receiver_went(connected.error().message);
    return connected;
  }

  void send(std::unique_lock<std::mutex>& lock, const StreamGrid::Due& due) {
    if (!due.again) {
      std::swap(shown, newest);
      shown_exposed = exposed;
      fresh = false;
    }
    counts.missed += due.missed;
    const bool first = std::exchange(fresh_receiver, false);
    lock.unlock();
    const Result<std::size_t> bytes = sink->write(shown, due.instant, first);
    const Timestamp out = studio_now();
    if (!bytes) receiver_went(bytes.error().message);
    lock.lock();
    if (!bytes || *bytes == 0) {
      ++counts.missed;
      if (!due.again) ++(bytes ? counts.overtaken : counts.unwatched);
      return;
    }
    counts.bytes += *bytes;
    ++(due.again ? counts.again : counts.sent);
    if (due.again || !shown_exposed) return;
    latencies.push_back(1e3 * seconds(out - *shown_exposed));
    if (latencies.size() > kMostLatencies) latencies.pop_front();
  }

  const StreamAddress address;
  const StreamOptions options;
  std::unique_ptr<StreamSink> sink;
  std::atomic<bool> ending{false};
  std::condition_variable wake;
  mutable std::mutex mutex;  // over what follows, but for `shown`, which is the thread's
  StreamGrid grid;
  Image newest, shown;
  std::optional<Timestamp> exposed, shown_exposed;
  bool fresh = false;           // `newest` has not been sent
  bool fresh_receiver = false;  // it has got nothing yet
  StreamReport counts;          // without latencies
  std::deque<double> latencies;
  std::thread thread;
};

StreamOutput::StreamOutput(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StreamOutput::~StreamOutput() = default;

Result<void> StreamOutput::check(const std::string& url, const StreamOptions& options) {
  if (options.width < 16 || options.height < 16 || options.width > 8192 || options.height > 8192)
    return fail(ErrorCode::InvalidArgument, text("a stream of ", options.width, "x", options.height,
                                                 " pictures; there are 16x16 to 8192x8192"));
  if (!(options.rate >= 1 && options.rate <= 240))
    return fail(ErrorCode::InvalidArgument,
                text("a stream of ", options.rate, " pictures a second; there are 1 to 240"));
  if (options.most_kbit < 100 || options.most_kbit > 1'000'000)
    return fail(ErrorCode::InvalidArgument,
                text("a stream of ", options.most_kbit, " kbit a second; there are 100 to 1000000"));
  const Result<StreamAddress> address = parse_stream_address(url);
  return address ? Result<void>() : forward(address);
}

Result<std::unique_ptr<StreamOutput>> StreamOutput::open(const std::string& url,
                                                         const StreamOptions& options) {
  if (Result<void> ok = check(url, options); !ok) return forward(ok);
  Result<StreamAddress> address = parse_stream_address(url);
  if (!address) return forward(address);
  if (Result<void> ok = warn_beyond_this_machine(*address); !ok) return forward(ok);
  auto impl = std::make_unique<Impl>(std::move(*address), options);
  if (Result<void> ok = impl->open(); !ok) return forward(ok);
  return std::unique_ptr<StreamOutput>(new StreamOutput(std::move(impl)));
}

void StreamOutput::offer(Image rgb, std::optional<Timestamp> exposed) {
  {
    std::lock_guard lock(impl_->mutex);
    StreamReport& counts = impl_->counts;
    ++counts.offered;
    if (impl_->fresh) ++(counts.connected ? counts.overtaken : counts.unwatched);
    std::swap(impl_->newest, rgb);
    impl_->exposed = exposed;
    impl_->fresh = true;
  }
  impl_->wake.notify_one();
}

StreamReport StreamOutput::report() const {
  std::lock_guard lock(impl_->mutex);
  StreamReport report = impl_->counts;
  report.latency_ms.assign(impl_->latencies.begin(), impl_->latencies.end());
  return report;
}

StreamOutput::Health StreamOutput::health() const {
  std::lock_guard lock(impl_->mutex);
  return {impl_->counts.connected, impl_->counts.trouble};
}

const std::string& StreamOutput::address() const { return impl_->address.shown; }

}  // namespace floatstage::capture
