// SPDX-License-Identifier: Apache-2.0
// drape_serve: a page for one person at this computer. It listens on the loopback interface alone.
// Requests need the random token in the address and come from its own page or from no page.
#include <httplib.h>
#undef _res  // a macro of resolv.h, and a name in Eigen
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/program_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/front/serve/built_in_page.h"
#include "tools/programs/front/serve/desk.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using httplib::Request, httplib::Response, httplib::Server;
using nlohmann::json;

constexpr std::size_t kMostUpload = 64 << 20, kMostWords = 1 << 16;  // [bytes]
constexpr int kThreads = 32;  // so many slow clients leave room for others
constexpr char kAddress[] = "127.0.0.1";
enum Status {
  kBadRequest = 400,
  kForbidden = 403,
  kNotFound = 404,
  kNotAllowed = 405,
  kTooLarge = 413,
  kOtherKind = 415,
  kServerError = 500
};

// The page runs its own scripts alone and is in no frame of others. A report has its own rules, and
// no rights on the page.
constexpr char kPagePolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";
constexpr char kFilePolicy[] = "sandbox allow-scripts allow-downloads";

std::string MakeToken() {
  unsigned char bytes[24];
  if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
    throw InputError("token", "the system has no random numbers");
  std::string token;
  for (const unsigned char byte : bytes) token += Format("%02x", byte);
  return token;
}

// Compares in a time that does not depend on where texts differ.
bool IsSame(const std::string& a, const std::string& b) {
  unsigned char difference = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

void Fail(Response& response, int status, const std::string& message) {
  response.status = status;
  response.set_content(json{{"error", MakePrintableLine(message)}}.dump(), "application/json");
}

// Sends a content as it is: to compress a page of results takes longer than to send it.
void Send(Response& response, std::string content, const char* type) {
  if (content.empty()) return response.set_content(content, type);
  const auto held = std::make_shared<const std::string>(std::move(content));
  response.set_content_provider(
      held->size(), type, [held](std::size_t begin, std::size_t length, httplib::DataSink& sink) {
        return sink.write(held->data() + begin, length);
      });
}

void Answer(Response& response, const json& value) {
  Send(response, value.dump(-1, ' ', false, json::error_handler_t::replace), "application/json");
}

// The kind of a picture by its first bytes; empty for what is none.
std::string PictureKind(std::string_view begin) {
  return begin.starts_with("\xFF\xD8\xFF")        ? "jpg"
         : begin.starts_with("\x89PNG\r\n\x1A\n") ? "png"
                                                  : "";
}

std::string ContentType(const std::string& name) {
  static const std::map<std::string, const char*> types = {{".html", "text/html; charset=utf-8"},
                                                           {".png", "image/png"},
                                                           {".jpg", "image/jpeg"},
                                                           {".json", "application/json"},
                                                           {".csv", "text/csv; charset=utf-8"},
                                                           {".txt", "text/plain; charset=utf-8"}};
  const auto found = types.find(fs::path(name).extension());
  return found == types.end() ? "application/octet-stream" : found->second;
}

class Site {
 public:
  Site(Desk* desk, int port)
      : desk_(*desk),
        hosts_{Format("%s:%d", kAddress, port), Format("localhost:%d", port)},
        root_(Format("/%s/", MakeToken().c_str())) {}

  std::string Address() const { return "http://" + hosts_[0] + root_; }

  // Tells the server what it answers.
  void Attach(Server* server) {
    server->set_pre_routing_handler([this](const Request& request, Response& response) {
      return Refuse(request, response) ? Server::HandlerResponse::Handled
                                       : Server::HandlerResponse::Unhandled;
    });
    server->Get(".*", [this](const Request& request, Response& response) {
      Try(response, [&] { Get(request, response); });
    });
    server->Post(".*", [this](const Request& request, Response& response,
                              const httplib::ContentReader& reader) {
      Try(response, [&] { Post(request, response, reader); });
    });
    server->set_default_headers({{"X-Content-Type-Options", "nosniff"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cross-Origin-Resource-Policy", "same-origin"},
                                 {"Cache-Control", "no-store"}});
  }

 private:
  // Returns whether a request is refused, before any of its content is read.
  bool Refuse(const Request& request, Response& response) const {
    const std::string host = request.get_header_value("Host");
    const bool is_own = std::ranges::count(hosts_, host) > 0;
    if (!is_own || request.get_header_value_count("Host") != 1)
      Fail(response, kForbidden, "another host");
    else if (request.has_header("Origin") && request.get_header_value("Origin") != "http://" + host)
      Fail(response, kForbidden, "another origin");
    else if (!IsSame(request.path.substr(0, root_.size()), root_))
      Fail(response, kForbidden, "no token, expected the address that drape_serve has printed");
    else if (request.method != "GET" && request.method != "POST")
      Fail(response, kNotAllowed, "another method");
    else if (request.has_header("Range") || request.is_multipart_form_data())
      Fail(response, kBadRequest, "ranges and forms are not known here");
    else
      return false;
    return true;
  }

  // Errors of the client, and of the system, become one line.
  static void Try(Response& response, const std::function<void()>& work) {
    try {
      work();
    } catch (const InputError& error) {
      const std::string line = error.what();
      Fail(response, line.ends_with("is not there") ? kNotFound : kBadRequest, line);
    } catch (const json::exception&) {
      Fail(response, kBadRequest, "the request is no JSON of the expected form");
    } catch (const std::exception& error) {
      Fail(response, kServerError, error.what());
    }
  }

  void Get(const Request& request, Response& response) {
    const std::string path = request.path.substr(root_.size());
    response.set_header("Content-Security-Policy", kPagePolicy);
    if (path.empty()) return Send(response, kDeskHtml, "text/html; charset=utf-8");
    if (path == "desk.js") return Send(response, kDeskScript, "text/javascript");
    if (path == "picture.js") return Send(response, kPictureScript, "text/javascript");
    if (path == "style.css") return Send(response, kReportStyle, "text/css");
    if (path == "desk.css") return Send(response, kDeskStyle, "text/css");
    if (path == "state")
      return Answer(response, desk_.State(std::atol(request.get_param_value("since").c_str())));
    if (path.starts_with("file/")) return SendFile(path.substr(5), response);
    throw InputError("page", "is not there");
  }

  void SendFile(const std::string& name, Response& response) {
    const std::size_t slash = name.find('/');
    if (slash == name.npos) throw InputError("file", "is not there");
    const std::string path = desk_.FindFile(name.substr(0, slash), name.substr(slash + 1));
    const std::string type = ContentType(path);
    response.headers.erase("Content-Security-Policy");
    response.set_header("Content-Security-Policy", kFilePolicy);
    if (type == "application/octet-stream")
      response.set_header("Content-Disposition", "attachment");
    Send(response, ReadOwnFile(path), type.c_str());
  }

  void Post(const Request& request, Response& response, const httplib::ContentReader& reader) {
    const std::string path = request.path.substr(root_.size());
    const std::size_t slash = path.find('/');
    const std::string verb = path.substr(0, slash),
                      id = slash == path.npos ? "" : path.substr(slash + 1);
    if (verb == "upload") return TakePicture(request, response, reader);
    std::string content;
    const bool is_whole = reader([&](const char* data, std::size_t length) {
      content.append(data, length);
      return content.size() <= kMostWords;
    });
    if (!is_whole) return Fail(response, kTooLarge, "the request is too long or broken");
    if (verb == "run") return Answer(response, {{"id", desk_.AddJob(json::parse(content))}});
    static const std::map<std::string, void (Desk::*)(const std::string&)> acts = {
        {"cancel", &Desk::Cancel}, {"retry", &Desk::Retry}, {"remove", &Desk::Remove}};
    if (verb != "change" && !acts.contains(verb)) throw InputError("page", "is not there");
    verb == "change" ? desk_.Change(id, json::parse(content)) : (desk_.*acts.at(verb))(id);
    Answer(response, json::object());
  }

  // Writes a picture to a folder of its own while it arrives. It is of a known kind by its content.
  void TakePicture(const Request& request, Response& response,
                   const httplib::ContentReader& reader) {
    const std::string staged = desk_.MakeStaged();
    const auto drop = [&](int status, const std::string& message) {
      std::error_code ignored;
      fs::remove_all(staged, ignored);
      Fail(response, status, message);
    };
    std::ofstream file(staged + "/upload", std::ios::binary);
    std::string begin, kind;
    std::size_t size = 0;
    constexpr std::size_t kSignature = 8;
    const bool is_whole = reader([&](const char* data, std::size_t length) {
      if (begin.size() < kSignature)
        begin.append(data, std::min(length, kSignature - begin.size()));
      if (begin.size() == kSignature && kind.empty() && (kind = PictureKind(begin)).empty())
        return false;
      size += length;
      file.write(data, std::streamsize(length));
      return size <= kMostUpload && file.good();
    });
    file.close();
    const bool was_announced = response.status == kTooLarge;  // by the header of the request
    if (was_announced || size > kMostUpload)
      return drop(kTooLarge, "the file is larger than 64 MiB");
    if (kind.empty()) return drop(kOtherKind, "the file is neither JPEG nor PNG");
    if (!is_whole || !file) return drop(kBadRequest, "the file did not arrive as a whole");
    try {
      fs::rename(staged + "/upload", staged + "/picture." + kind);
      Answer(
          response,
          {{"id", desk_.AddPicture(staged, "picture." + kind, request.get_param_value("name"))}});
    } catch (const InputError& error) {
      drop(kBadRequest, error.what());
    }
  }

  Desk& desk_;
  const std::string hosts_[2];
  const std::string root_;  // of all paths
};

OptionTable ServeTable(DeskOptions& options) {
  return {.tool = "drape_serve",
          .summary = "shows a page on which photographs are measured, fitted and compared",
          .example = "drape_serve --out=out/desk",
          .notes =
              "Open the printed address in a browser of this computer; others cannot reach it. It "
              "is new at each start. The page runs the programs of drapefit and shows their "
              "commands. Photographs and results are in the folder OUT. A desk that was stopped "
              "continues what it had begun.\n",
          .options = {OutOption(options.out),
                      NumberOption("port", &options.port, 0, 65535, "port; 0: a free one"),
                      NumberOption("jobs", &options.jobs, 1, 64,
                                   "number of fits and other jobs that run at a time"),
                      PathOption("fit_config", &options.fit_config,
                                 "config file of fits, as of drapefit; empty: its own"),
                      ThreadsOption(options.threads)}};
}

// Ports are not shared with other servers.
void SetSocketOptions(socket_t socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

ToolOutcome Run(const DeskOptions& options, const RunControl& control) {
  const std::string programs = ProgramFolder();
  if (!HasProgram(programs, "photo"))
    throw InputError("drape_photo", "is not among the programs here, expected for photographs");
  Server server;
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_socket_options(SetSocketOptions);
  server.set_keep_alive_max_count(1);
  server.set_read_timeout(5);
  server.set_write_timeout(5);
  server.set_payload_max_length(kMostUpload);
  const int port = options.port == 0 ? server.bind_to_any_port(kAddress) : options.port;
  if (options.port != 0 && !server.bind_to_port(kAddress, options.port))
    throw InputError("option 'port'",
                     Format("port %d is not free, expected another or 0", options.port));
  Desk desk(options);
  Site site(&desk, port);
  site.Attach(&server);
  std::printf("%s\n", site.Address().c_str());
  std::fflush(stdout);
  control.Report(0, "listens");  // it reads no input that takes long
  const std::jthread watch([&](const std::stop_token& closed) {
    while (!control.cancelled() && !closed.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (closed.stop_requested()) return;
    desk.Stop();
    OutputFolder::Abandon();  // uploads that have not arrived
    _exit(kExitCancelled);    // slow clients are not waited for
  });
  server.listen_after_bind();
  throw InputError("port", "the system has closed it");
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::ServeTable, drape::Run);
}
