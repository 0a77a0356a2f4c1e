"""Fonts of many scripts and a player for slow tests, from the registry that npm is set up with.

``tests/registry/package.json`` names them. They are installed when a test first asks for one, and
the tests are skipped where that is not possible.
"""

from __future__ import annotations

import functools
import shutil
import subprocess
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "registry"

LATIN = (
    "AVATAR Toy. Wave LTD, Yield fiche office Täuffelen «Æsir» fjord quixotic T.V. WAVY "
    "hamburgevons $1,750 Öl-Tank naïve khaki figs Genève façade Zürich"
).split()[:20]
GREEK = (
    "ΑΥΤΟΣ Ελλάδα γλώσσα ΤΑΞΙ Άνθρωπος ϋπνος φύλλο ΛΑΟΣ Θάλασσα ψυχή "
    "ΓΑΛΑ Ρόδος κόσμος ώρα ΥΔΩΡ έτος ήλιος ΑΪ νύχτα Τέλος"
).split()
CYRILLIC = (
    "ГАУДИ Тула рУКА Город ТЕАТР объём Йод Ёлка УДА слово "
    "РГБ Аэропорт вьюга щука Хутор Дядя КАТОК Юг ТУР фильм"
).split()
ARABIC = (
    "مَرْحَبًا سلام كِتَاب الله لَا العربية شُكْرًا محمّد قهوة بيت مدرسة نَهْر صباح لؤلؤة ذهب ضوء ظلّ غيم خبز ثلج"
).split()
URDU = (
    "نستعلیق حُسْن پاکستان چائے کتاب گھر محبت ٹھیک ڈاکٹر لڑکا "
    "ہمیشہ ژالہ خط بہت سچّ میں نہیں پھول شہر یقین"
).split()
HEBREW = (
    "שָׁלוֹם עִבְרִית ספר בַּיִת תודה יְרוּשָׁלַ\u034fִם אֱמֶת לחם מים חלום אור יֶלֶד כּוֹכָב ציפור גן פרח שׂדה עץ קול זמן"
).split()
DEVANAGARI = (
    "हिन्दी क्षेत्र नमस्ते श्री विद्यार्थी कृष्ण ज्ञान पुस्तक द्वार र्कि "
    "ट्रेन प्रेम शक्ति स्त्री ऊँचा दुःख मूर्ति हृदय रुपया गंगा"
).split()
BENGALI = (
    "বাংলা ক্ষমা কৃষ্ণ স্ত্রী র্কি প্রেম দুঃখ চাঁদ বিদ্যালয় জ্ঞান শ্রী বন্ধু হৃদয় নদী পাখি ফুল সূর্য গ্রাম মানুষ আকাশ"
).split()
KHMER = (
    "ខ្មែរ ក្រុង ភាសា សួស្តី អរគុណ ស្រី ខ្ញុំ ទឹក ផ្ទះ ប្រទេស កម្ពុជា សៀវភៅ ឆ្មា ភ្នំ ព្រះ ស្រស់ ដំរី ជ្រូក ផ្លែ ចេក"
).split()
THAI = (
    "ภาษาไทย น้ำ ที่นี่ ปู่ย่า กุ้ง ฟ้า ป้ำ ผู้ใหญ่ เชียงใหม่ ญี่ปุ่น ฐูฏุ สวัสดี ขอบคุณ หมู่ ซื้อ เพื่อน ปลา ฝัน ใจดี ก๋วยเตี๋ยว"
).split()
HANGUL = (
    "나무 대문 바나나 서문 소나무 수영 신문 여우 오전 우유 "
    "의자 자전거 정원 조카 주문 타조 포도 호수 모자 개미"
).split()

SUBSETS = {
    "latin": LATIN,
    "greek": GREEK,
    "cyrillic": CYRILLIC,
    "arabic": ARABIC,
    "hebrew": HEBREW,
    "devanagari": DEVANAGARI,
    "bengali": BENGALI,
    "khmer": KHMER,
    "thai": THAI,
    "118": HANGUL,
}
FILES = """
alegreya/alegreya-latin-wght-italic
cairo/cairo-arabic-slnt-normal
crimson-pro/crimson-pro-latin-wght-normal
eb-garamond/eb-garamond-greek-wght-normal
eb-garamond/eb-garamond-latin-wght-italic
fraunces/fraunces-latin-full-italic
fraunces/fraunces-latin-full-normal
hahmlet/hahmlet-118-wght-normal
inter/inter-cyrillic-opsz-normal
inter/inter-greek-opsz-italic
inter/inter-latin-opsz-normal
literata/literata-latin-opsz-italic
mada/mada-arabic-wght-normal
montserrat/montserrat-cyrillic-wght-normal
noto-kufi-arabic/noto-kufi-arabic-arabic-wght-normal
noto-nastaliq-urdu/noto-nastaliq-urdu-arabic-wght-normal
noto-sans-arabic/noto-sans-arabic-arabic-standard-normal
noto-sans-bengali/noto-sans-bengali-bengali-standard-normal
noto-sans-devanagari/noto-sans-devanagari-devanagari-standard-normal
noto-sans-hebrew/noto-sans-hebrew-hebrew-standard-normal
noto-sans-khmer/noto-sans-khmer-khmer-standard-normal
noto-sans-thai/noto-sans-thai-thai-standard-normal
noto-serif-khmer/noto-serif-khmer-khmer-standard-normal
noto-serif-thai/noto-serif-thai-thai-standard-normal
open-sans/open-sans-hebrew-standard-normal
playfair-display/playfair-display-latin-wght-normal
rubik/rubik-hebrew-wght-normal
source-serif-4/source-serif-4-latin-opsz-italic
vazirmatn/vazirmatn-arabic-wght-normal
""".split()


def words(file: str) -> list[str]:
    """Twenty words in the script of a font file."""
    if "nastaliq" in file:
        return URDU
    name = file.partition("/")[2]
    return next(words for subset, words in SUBSETS.items() if f"-{subset}-" in name)


@functools.cache
def package(name: str) -> Path:
    """The folder of a package that ``tests/registry/package.json`` names."""
    folder = FOLDER / "node_modules" / name
    if not folder.is_dir():
        npm = shutil.which("npm")
        if npm is None:
            pytest.skip(f"npm, which fetches {name} for this test, is not installed")
        done = subprocess.run([npm, "ci"], cwd=FOLDER, capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"npm could not fetch {name} for this test: {done.stderr[-200:]}")
    return folder


def path(file: str) -> Path:
    """The file of a font in ``FILES``."""
    font, name = file.split("/")
    return package("@fontsource-variable") / font / "files" / f"{name}.woff2"
