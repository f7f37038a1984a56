#include "haptics/base/text/PlainText.h"

#include <cstdarg>
#include <cstdio>
#include <vector>

#include <locale.h> // newlocale

namespace midair::base
{

namespace
{

/// Sets the locale "C" for this thread while in scope.
class PlainLocale
{
public:
    PlainLocale()
    {
        static const locale_t kPlain = ::newlocale(LC_ALL_MASK, "C", nullptr);
        if (kPlain != nullptr) _before = ::uselocale(kPlain);
    }
    ~PlainLocale()
    {
        if (_before != nullptr) ::uselocale(_before);
    }
    PlainLocale(const PlainLocale&) = delete;
    PlainLocale& operator=(const PlainLocale&) = delete;

private:
    locale_t _before = nullptr;
};

} // namespace

std::string plainText(const char* pattern, ...)
{
    const PlainLocale plain;
    std::vector<char> text(256);
    va_list values;
    va_list again;
    va_start(values, pattern);
    va_copy(again, values);
    const int length = std::vsnprintf(text.data(), text.size(), pattern, values);
    va_end(values);
    if (length >= static_cast<int>(text.size()))
    {
        text.resize(static_cast<std::size_t>(length) + 1);
        std::vsnprintf(text.data(), text.size(), pattern, again);
    }
    va_end(again);
    return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : std::string();
}

} // namespace midair::base
