#include "studio/network/control_client.h"

#include <chrono>

#include "core/text.h"
#include "studio/messages/control_message.h"
#include "studio/network/link.h"

namespace floatstage::studio::wire {
namespace {

ControlReply ask(const std::string& address, const std::optional<StudioKeys>& keys, Nanoseconds patience,
                 const ControlRequest& request) {
  const Result<std::string> sealed = encode_request(request);
  if (!sealed) return forward(sealed);
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::dealer);
  prepare(socket, static_cast<std::int64_t>(kLargestMessage), Heartbeats::Given);
  become_client(socket, keys);
  if (Result<void> connected = connect_to(socket, address, keys); !connected) return forward(connected);
  socket.send(zmq::buffer(*sealed), zmq::send_flags::dontwait);
  zmq::pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
  wait_for(std::span(&item, 1),
           std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::nanoseconds(patience.count)));
  zmq::message_t reply;
  if (!socket.recv(reply, zmq::recv_flags::dontwait))
    return fail(ErrorCode::Timeout, text("'", address, "': no answer within ", seconds(patience),
                                         " s; is the node running, and are its keys the same?"));
  const Result<Message> message = open(bytes_of(reply));
  if (!message) return forward(message);
  return decode_reply(*message);
}

}  // namespace

Result<std::unique_ptr<ControlClient>> ControlClient::connect(const std::string& address,
                                                              const std::optional<StudioKeys>& keys,
                                                              Nanoseconds patience) {
  if (Result<void> allowed = check_address(address, keys); !allowed) return forward(allowed);
  return std::unique_ptr<ControlClient>(new ControlClient(address, keys, patience));
}

Result<NodeStatus> ControlClient::ask_status() const {
  const ControlReply reply = ask(address_, keys_, patience_, {Ask::Status, ""});
  if (!reply) return forward(reply);
  return parse_node_status(*reply);
}

NodeStatus ControlClient::status() const {
  Result<NodeStatus> asked = ask_status();
  if (asked) return *asked;
  NodeStatus unknown;
  unknown.node = address_;
  unknown.complaints = {asked.error().message};
  return unknown;
}

Result<std::string> ControlClient::start_recording(const std::string& label) {
  return ask(address_, keys_, patience_, {Ask::StartRecording, label});
}

Result<void> ControlClient::stop_recording() {
  const ControlReply reply = ask(address_, keys_, patience_, {Ask::StopRecording, ""});
  if (!reply) return forward(reply);
  return {};
}

Result<std::vector<NodeTake>> ControlClient::takes() const {
  const ControlReply reply = ask(address_, keys_, patience_, {Ask::Takes, ""});
  if (!reply) return forward(reply);
  return parse_node_takes(*reply);
}

}  // namespace floatstage::studio::wire
