#pragma once

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <locale>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

/// While it lives the program's locale, C's and C++'s, is German: a decimal comma, points between
/// the thousands. Made with localedef from the package "locales" where the machine has none;
/// isSet() is false where that can't be, and the test then is to be skipped.
class CommaLocale
{
public:
    CommaLocale()
    {
        if (set()) return;
        const std::string command =
            "localedef --no-archive -i de_DE -f UTF-8 '" + _folder + "/" + kName + "' 2>&1";
        std::filesystem::create_directories(_folder);
        if (std::system(command.c_str()) != 0)
        {
            std::cerr << "SKIPPED, so locales are not tested: \"" << command
                      << "\" fails; install Debian's package locales\n";
            return;
        }
        ::setenv("LOCPATH", _folder.c_str(), 1);
        set();
    }
    ~CommaLocale()
    {
        std::locale::global(std::locale::classic());
        std::setlocale(LC_ALL, "C");
        ::unsetenv("LOCPATH");
        std::error_code ignored;
        std::filesystem::remove_all(_folder, ignored);
    }
    CommaLocale(const CommaLocale&) = delete;
    CommaLocale& operator=(const CommaLocale&) = delete;

    bool isSet() const { return _set; }

private:
    static constexpr const char* kName = "de_DE.UTF-8";

    bool set()
    {
        try
        {
            std::locale::global(std::locale(kName)); // C's too
        }
        catch (const std::runtime_error&)
        {
            return false;
        }
        _set = std::string(std::localeconv()->decimal_point) == ",";
        return _set;
    }

    const std::string _folder =
        ::testing::TempDir() + "midair-locale-" + std::to_string(::getpid());
    bool _set = false;
};
