#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/tcp_stream.hpp>

namespace floatstage::studio {

namespace net = boost::asio;
namespace beast = boost::beast;
using net::ip::tcp;

}  // namespace floatstage::studio
