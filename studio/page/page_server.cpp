#include "studio/page/page_server.h"

#include <atomic>
#include <thread>

#include "capture_page/page_files.h"
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>

#include "core/log.h"
#include "core/text.h"
#include "studio/messages/status_json.h"
#include "studio/page/page_access.h"
#include "studio/page/page_answers.h"
#include "studio/page/page_connection.h"
#include "studio/page/page_strangers.h"
#include "studio/page/page_viewers.h"
#include "studio/page/preview.h"
#include "studio/page/zoom_feed.h"

namespace floatstage::studio {
namespace {

constexpr double kPreviewsPerSecond = 8;
constexpr auto kStatusPeriod = std::chrono::milliseconds(500);
// Each viewer costs a socket and its queue of previews; each stranger a socket.
constexpr std::size_t kMostViewers = 64, kMostStrangers = 1024, kMostStrangersOfAnAddress = 256;
constexpr const char* kPlain = "text/plain; charset=utf-8";

PageAnswer file_answer(const std::string& path) {
  if (path == "/") return {200, "text/html; charset=utf-8", std::string(page::kHtml), {}};
  if (path == "/page.css") return {200, "text/css; charset=utf-8", std::string(page::kCss), {}};
  if (path == "/page.js") return {200, "text/javascript; charset=utf-8", std::string(page::kJs), {}};
  if (path == "/focus.js") return {200, "text/javascript; charset=utf-8", std::string(page::kFocus), {}};
  return {404, kPlain, "There is nothing here.\n", {}};
}

PageAnswer refusal(PageAccess::Verdict verdict) {
  using Verdict = PageAccess::Verdict;
  if (verdict == Verdict::OtherSite) return {403, kPlain, "Another site's page may not ask this.\n", {}};
  if (verdict == Verdict::OtherName)
    return {403,
            kPlain,
            "This name is none of the studio's: use its address, or give it the name in [web] names.\n",
            {}};
  return {401, kPlain, "This page needs its token: open the address that the node's log tells.\n",
          "WWW-Authenticate: Bearer realm=\"floatstage\"\r\n"};
}

}  // namespace

struct PageServer::Impl {
  Impl(StudioControl& c, std::size_t cameras_, std::string address_, std::string token_)
      : control(c), cameras(cameras_), address(std::move(address_)), token(std::move(token_)) {}

  beast::error_code open(const tcp::endpoint& where) {
    beast::error_code error;
    acceptor.open(where.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(where, error);
    if (!error) acceptor.listen(net::socket_base::max_listen_connections, error);
    if (!error) port = acceptor.local_endpoint(error).port();
    return error;
  }

  void run(const std::vector<std::string>& names) {
    access = std::make_unique<PageAccess>(token, port, names);
    // One byte says whose picture it is.
    const auto send = [this](int camera, const std::shared_ptr<const std::string>& jpeg) {
      to_viewers({PageViewers::Message::Kind::Binary,
                  std::make_shared<const std::string>(std::string(1, static_cast<char>(camera)) + *jpeg)});
    };
    previews = std::make_unique<PreviewFeed>(cameras, kPreviewsPerSecond, send);
    accept();
    tell_status();
    sockets = std::thread([this] { io.run(); });
  }

  // Whoever is connected is cut off: nothing is written or answered after the sockets' thread has ended.
  ~Impl() {
    io.stop();
    if (sockets.joinable()) sockets.join();
    previews.reset();
    for (net::thread_pool* threads : {&orders, &knobs, &questions, &looks}) threads->stop();
    for (net::thread_pool* threads : {&orders, &knobs, &questions, &looks}) threads->join();
  }

  void accept() {
    acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
      if (!error) greet(std::move(socket));
      if (error == net::error::no_descriptors) {  // until somebody leaves
        pause.expires_after(kStatusPeriod);
        pause.async_wait([this](beast::error_code) { accept(); });
      } else {
        accept();
      }
    });
  }

  void greet(tcp::socket socket) {
    beast::error_code error;
    socket.set_option(tcp::no_delay(true), error);
    const tcp::endpoint from = socket.remote_endpoint(error);
    if (error) return;  // it has gone
    strangers.add(std::make_shared<PageConnection>(std::move(socket)), from.address().to_string(),
                  [this](const std::shared_ptr<PageConnection>& c, const PageRequest& r) { handle(c, r); });
  }

  void handle(const std::shared_ptr<PageConnection>& connection, const PageRequest& request) {
    ++requests;
    if (const PageAccess::Verdict verdict = access->judge(request); verdict != PageAccess::Verdict::Welcome) {
      ++refused;
      connection->answer(refusal(verdict));
    } else if (request.path == "/" && !request.query_value("token").empty()) {
      // The address bar and the history shall not keep the token.
      connection->answer(
          {303, kPlain, "", text("Location: /\r\nSet-Cookie: ", access->new_session(), "\r\n")});
    } else if (request.path == "/live" && connection->wants_live()) {
      if (viewers.count() >= kMostViewers)
        return connection->answer({503, kPlain, text(kMostViewers, " watch already.\n"), {}});
      auto upgrade = connection->take_request();
      viewers.add(connection->take_stream(), std::move(upgrade));
    } else if (is_order(request) && request.method != "POST") {
      connection->answer({405, "application/json", R"({"error":"POST it"})", "Allow: POST\r\n"});
    } else if (is_order(request)) {
      // A camera that hangs keeps its knobs waiting, and no take.
      later(is_order_to_cameras(request) ? knobs : orders, connection,
            [this, request] { return carry_out(control, request); });
    } else if (is_question(request)) {
      later(questions, connection, [this, path = request.path] { return reply(path); });
    } else if (request.path == "/api/zoom") {
      later(looks, connection, [this, request] { return look(zoom, cameras, request); });
    } else {
      connection->answer(file_answer(request.path));
    }
  }

  PageAnswer reply(const std::string& path) const {
    if (path != "/metrics") return answer_question(control, path);
    return {
        200, "text/plain; version=0.0.4; charset=utf-8", prometheus_text(control.status(), counters()), {}};
  }

  // On another thread, if the client is still there when its turn comes.
  template <typename Work>
  void later(net::thread_pool& threads, const std::shared_ptr<PageConnection>& connection, Work work) {
    connection->watch();
    net::post(threads, [this, connection, work = std::move(work)] {
      if (connection->gone()) return;
      net::post(io, [connection, answer = work()] { connection->answer(answer); });
    });
  }

  void to_viewers(PageViewers::Message message) {
    net::post(io, [this, message = std::move(message)] { viewers.send(message); });
  }

  // The status, to everybody who watches.
  void tell_status() {
    timer.expires_after(kStatusPeriod);
    timer.async_wait([this](beast::error_code) {
      const bool watched = viewers.count() > 0;
      previews->set_wanted(watched);
      if (watched)
        net::post(questions, [this] {
          to_viewers({PageViewers::Message::Kind::Text,
                      std::make_shared<const std::string>(wire::to_json(control.status()))});
        });
      tell_status();
    });
  }

  PageCounters counters() const { return {requests, refused, viewers.count(), viewers.dropped()}; }

  StudioControl& control;
  const std::size_t cameras;
  const std::string address, token;
  int port = 0;
  net::io_context io{1};
  tcp::acceptor acceptor{io};
  std::unique_ptr<PageAccess> access;
  net::steady_timer timer{io}, pause{io};
  PageStrangers strangers{kMostStrangersOfAnAddress, kMostStrangers};
  PageViewers viewers{2 * cameras + 4};
  ZoomFeed zoom;
  net::thread_pool orders{1}, knobs{1}, questions{1}, looks{1};
  std::unique_ptr<PreviewFeed> previews;
  std::atomic<std::uint64_t> requests{0}, refused{0};
  std::thread sockets;
};

PageServer::PageServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PageServer::~PageServer() = default;

Result<std::unique_ptr<PageServer>> PageServer::serve(StudioControl& control, std::size_t cameras,
                                                      const PageSettings& settings, std::string token) {
  beast::error_code error;
  const net::ip::address address = net::ip::make_address(settings.address, error);
  if (error)
    return fail(ErrorCode::InvalidArgument,
                text("'", settings.address,
                     "' in [web] is no address: say 127.0.0.1, one of this machine's, or 0.0.0.0"));
  auto impl = std::make_unique<Impl>(control, cameras, settings.address, std::move(token));
  error = impl->open({address, static_cast<std::uint16_t>(settings.port)});
  if (error)
    return fail(ErrorCode::Io, text("the page cannot be served at ", settings.address, ":", settings.port,
                                    " (", error.message(), "); is the port taken? choose another in [web]"));
  if (!address.is_loopback())
    log::warning(text("the page at ", settings.address,
                      " is not encrypted: whoever hears that network hears its "
                      "token; use a network of the studio's own, or 127.0.0.1 and ssh"));
  impl->run(settings.names);
  return std::unique_ptr<PageServer>(new PageServer(std::move(impl)));
}

int PageServer::port() const { return impl_->port; }

std::string PageServer::url() const {
  const bool bracketed = impl_->address.find(':') != std::string::npos;
  return text("http://", bracketed ? "[" : "", impl_->address, bracketed ? "]" : "", ":", impl_->port,
              "/?token=", impl_->token);
}

PageCounters PageServer::counters() const { return impl_->counters(); }

void PageServer::offer(const Frame& frame) {
  impl_->previews->offer(frame);
  impl_->zoom.offer(frame);
}

}  // namespace floatstage::studio
