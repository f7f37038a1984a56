#include "samples/monitor/server/PlainAnswer.h"

#include <fmt/format.h>

namespace midair::samples
{

std::string plainAnswer(int status, const std::string& text)
{
    const char* reason = "Error";
    switch (status)
    {
    case 400:
        reason = "Bad Request";
        break;
    case 408:
        reason = "Request Timeout";
        break;
    case 431:
        reason = "Request Header Fields Too Large";
        break;
    case 500:
        reason = "Internal Server Error";
        break;
    case 503:
        reason = "Service Unavailable";
        break;
    case 504:
        reason = "Gateway Timeout";
        break;
    default:
        break;
    }
    return fmt::format("HTTP/1.1 {} {}\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: "
                       "{}\r\nX-Content-Type-Options: nosniff\r\n\r\n{}\n",
                       status,
                       reason,
                       "text/plain; charset=utf-8",
                       text.size() + 1,
                       text);
}

} // namespace midair::samples
