// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The files of page/, and the style of the page of drape_report, compiled in.
extern const char* const kDeskHtml;
extern const char* const kDeskScript;     // desk.js
extern const char* const kPictureScript;  // picture.js
extern const char* const kDeskStyle;
extern const char* const kReportStyle;

}  // namespace drape
