#include "studio/node/page_server.h"

#include <algorithm>
#include <cstring>

#include "capture_page/page_files.h"
#include <civetweb.h>
#include <nlohmann/json.hpp>
#include <sys/random.h>

#include "core/check.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text.h"
#include "studio/messages/status_json.h"
#include "studio/node/thread_stack.h"

namespace floatstage::studio {
namespace {

constexpr double kPreviewsPerSecond = 8;
constexpr auto kStatusPeriod = std::chrono::milliseconds(500);
constexpr std::size_t kShortestToken = 16;
// Workers: each viewer keeps one busy.
constexpr const char* kThreads = "16";

constexpr const char* kPageHeaders =
    "Content-Security-Policy: default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self' blob: "
    "data:; "
    "connect-src 'self' ws: wss:; base-uri 'none'; frame-ancestors 'none'; form-action 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n";

void answer(mg_connection* connection, int status, const char* type, std::string_view body,
            const std::string& more = "") {
  mg_printf(connection,
            "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n%s%sConnection: close\r\n\r\n",
            status, mg_get_response_code_text(connection, status), type, body.size(), kPageHeaders,
            more.c_str());
  mg_write(connection, body.data(), body.size());
}

void answer_json(mg_connection* connection, int status, const std::string& json) {
  answer(connection, status, "application/json", json);
}

void answer_error(mg_connection* connection, const Error& error) {
  const int status = error.code == ErrorCode::AlreadyExists || error.code == ErrorCode::NotFound ? 409
                     : error.code == ErrorCode::InvalidArgument                                  ? 400
                                                                                                 : 500;
  answer_json(connection, status,
              nlohmann::json{{"error", error.message}}.dump(-1, ' ', false,
                                                            nlohmann::json::error_handler_t::replace));
}

// Takes the same time wherever they differ.
bool same_secret(std::string_view given, std::string_view wanted) {
  unsigned difference = given.size() == wanted.size() ? 0 : 1;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    difference |=
        static_cast<unsigned char>(wanted[i]) ^ static_cast<unsigned char>(i < given.size() ? given[i] : 0);
  return difference == 0;
}

std::string query_value(const char* query, const char* key) {
  char value[512];
  const int length = query ? mg_get_var(query, std::strlen(query), key, value, sizeof value) : -1;
  return length > 0 ? std::string(value, static_cast<std::size_t>(length)) : "";
}

PageServer& server_of(const mg_connection* connection) {
  return *static_cast<PageServer*>(mg_get_user_data(mg_get_context(connection)));
}

bool is_token_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

}  // namespace

struct PageServer::Request {
  explicit Request(mg_connection* connection) {
    const mg_request_info* info = mg_get_request_info(connection);
    const auto known = [](const char* text) { return std::string(text ? text : ""); };
    method = known(info->request_method);
    path = known(info->local_uri);
    query = info->query_string;
    authorization = known(mg_get_header(connection, "Authorization"));
    cookies = known(mg_get_header(connection, "Cookie"));
  }
  std::string method, path, authorization, cookies;
  const char* query = nullptr;
};

Result<std::string> page_token(const std::filesystem::path& file) {
  if (file.empty()) {
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
      return fail(ErrorCode::Io, "the system gives no random numbers for a token");
    std::string token;
    for (const unsigned char byte : bytes) {
      token += "0123456789abcdef"[byte >> 4];
      token += "0123456789abcdef"[byte & 15];
    }
    return token;
  }
  const Result<std::string> text_of_file = read_file(file);
  if (!text_of_file) return forward(text_of_file);
  const std::string token = text_of_file->substr(0, text_of_file->find_first_of("\r\n"));
  if (token.size() < kShortestToken || !std::all_of(token.begin(), token.end(), is_token_letter))
    return fail(ErrorCode::InvalidArgument,
                text(file.string(), ": its first line is no token; use at least ", kShortestToken,
                     " letters, digits, '-' and '_', for example of: openssl rand -hex 16"));
  return token;
}

Result<std::unique_ptr<PageServer>> PageServer::serve(StudioControl& control, std::size_t cameras,
                                                      const CaptureConfig::Web& web, std::string token) {
  std::unique_ptr<PageServer> server(new PageServer(control, web.address, std::move(token)));
  if (Result<void> started = server->start(cameras, web.port); !started) return forward(started);
  return server;
}

Result<void> PageServer::start(std::size_t cameras, int port) {
  viewers_ = std::make_unique<PageViewers>(2 * cameras + 4);
  previews_ = std::make_unique<
      PreviewFeed>(cameras, kPreviewsPerSecond, [this](int camera, std::shared_ptr<const std::string> jpeg) {
    // One byte says whose picture it is.
    const std::string head(1, static_cast<char>(camera));
    viewers_->send({PageViewers::Message::Kind::Binary, std::make_shared<const std::string>(head + *jpeg)});
  });
  const std::string where =
      text(address_.find(':') == std::string::npos ? address_ : "[" + address_ + "]", ":", port);
  const char* options[] = {"listening_ports",
                           where.c_str(),
                           "num_threads",
                           kThreads,
                           "request_timeout_ms",
                           "5000",
                           "tcp_nodelay",
                           "1",
                           "websocket_timeout_ms",
                           "5000",
                           "enable_websocket_ping_pong",
                           "yes",
                           nullptr};
  mg_callbacks callbacks = {};
  callbacks.begin_request = [](mg_connection* c) { return server_of(c).begin_request(c); };
  callbacks.log_message = [](const mg_connection*, const char* message) {
    log::debug(text("page: ", message));
    return 1;
  };
  FLOATSTAGE_CHECK(small_stacks_are_raised(), "civetweb's threads have no room");
  mg_init_library(0);
  mg_init_data init = {};
  init.callbacks = &callbacks;
  init.user_data = this;
  init.configuration_options = options;
  char why[256] = "";
  mg_error_data error = {};
  error.text = why;
  error.text_buffer_size = sizeof why;
  context_ = mg_start2(&init, &error);
  mg_server_port served = {};
  if (!context_ || mg_get_server_ports(context_, 1, &served) != 1)
    return fail(ErrorCode::Io, text("the page cannot be served at ", where, " (", why,
                                    "); is the port taken? choose another in [web]"));
  port_ = served.port;
  // Cookies do not know ports: two nodes of one machine need two names.
  cookie_ = text("floatstage_", port_);
  mg_set_request_handler(
      context_, "/", [](mg_connection* c, void* self) { return static_cast<PageServer*>(self)->handle(c); },
      this);
  mg_set_websocket_handler(
      context_, "/live", [](const mg_connection*, void*) { return 0; },
      [](mg_connection* c, void* self) { static_cast<PageServer*>(self)->viewers_->add(c); },
      [](mg_connection*, int bits, char*, size_t, void*) {  // nothing is expected; closing is
        return (bits & 0xf) == MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE ? 0 : 1;
      },
      [](const mg_connection* c, void* self) {
        static_cast<PageServer*>(self)->viewers_->remove(const_cast<mg_connection*>(c));
      },
      this);
  status_thread_ = std::thread([this] { send_status(); });
  return {};
}

PageServer::~PageServer() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (status_thread_.joinable()) status_thread_.join();
  previews_.reset();
  if (viewers_) viewers_->close();
  if (context_) mg_stop(context_);
  mg_exit_library();
}

std::string PageServer::url() const { return text("http://", address_, ":", port_, "/?token=", token_); }

PageCounters PageServer::counters() const {
  return {requests_, refused_, viewers_->count(), viewers_->dropped()};
}

bool PageServer::knows_token(const Request& request) const {
  constexpr std::string_view kBearer = "Bearer ";
  if (request.authorization.starts_with(kBearer))
    return same_secret(std::string_view(request.authorization).substr(kBearer.size()), token_);
  if (const std::string given = query_value(request.query, "token"); !given.empty())
    return same_secret(given, token_);
  char value[512];
  const int length = mg_get_cookie(request.cookies.c_str(), cookie_.c_str(), value, sizeof value);
  return length > 0 && same_secret({value, static_cast<std::size_t>(length)}, token_);
}

// Every request, also for the live connection, passes here first. 0: go on.
int PageServer::begin_request(mg_connection* connection) {
  ++requests_;
  const Request request(connection);
  if (!knows_token(request)) {
    ++refused_;
    answer(connection, 401, "text/plain; charset=utf-8",
           "This page needs its token: open the address that the node's log tells.\n",
           "WWW-Authenticate: Bearer realm=\"floatstage\"\r\n");
    return 401;
  }
  if (request.path == "/" && !query_value(request.query, "token").empty()) {
    // The address bar and the history shall not keep the token.
    answer(
        connection, 303, "text/plain", "",
        text("Location: /\r\nSet-Cookie: ", cookie_, "=", token_, "; Path=/; HttpOnly; SameSite=Strict\r\n"));
    return 303;
  }
  return 0;
}

int PageServer::command(mg_connection* connection, const Request& request) {
  if (request.method != "POST") {
    answer_json(connection, 405, R"({"error":"POST it"})");
    return 405;
  }
  if (request.path == "/api/stop") {
    const Result<void> stopped = control_.stop_recording();
    stopped ? answer_json(connection, 200, "{}") : answer_error(connection, stopped.error());
    return 200;
  }
  const Result<std::string> take = control_.start_recording(query_value(request.query, "label"));
  take ? answer_json(connection, 200, nlohmann::json{{"take", *take}}.dump())
       : answer_error(connection, take.error());
  return 200;
}

int PageServer::handle(mg_connection* connection) {
  const Request request(connection);
  if (request.path == "/api/record" || request.path == "/api/stop") return command(connection, request);
  if (request.path == "/api/status") {
    answer_json(connection, 200, wire::to_json(control_.status()));
  } else if (request.path == "/api/takes") {
    const Result<std::vector<NodeTake>> takes = control_.takes();
    takes ? answer_json(connection, 200, wire::to_json(*takes)) : answer_error(connection, takes.error());
  } else if (request.path == "/metrics") {
    answer(connection, 200, "text/plain; version=0.0.4; charset=utf-8",
           prometheus_text(control_.status(), counters()));
  } else if (request.path == "/") {
    answer(connection, 200, "text/html; charset=utf-8", page::kHtml);
  } else if (request.path == "/page.css") {
    answer(connection, 200, "text/css; charset=utf-8", page::kCss);
  } else if (request.path == "/page.js") {
    answer(connection, 200, "text/javascript; charset=utf-8", page::kJs);
  } else {
    answer(connection, 404, "text/plain; charset=utf-8", "There is nothing here.\n");
    return 404;
  }
  return 200;
}

// The status, to everybody who watches.
void PageServer::send_status() {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kStatusPeriod, [&] { return stopping_; })) {
    const bool watched = viewers_->count() > 0;
    previews_->set_wanted(watched);
    if (!watched) continue;
    lock.unlock();
    viewers_->send({PageViewers::Message::Kind::Text,
                    std::make_shared<const std::string>(wire::to_json(control_.status()))});
    lock.lock();
  }
}

}  // namespace floatstage::studio
