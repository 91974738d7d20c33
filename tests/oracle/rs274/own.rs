//! Programs in the words that LinuxCNC has too, in millimetres: name and text.

pub(crate) const PROGRAMS: &[(&str, &str)] = &[
    (
        "lines and arcs in three planes",
        "G17 G90 G54\nG0 X0 Y0 Z0\nG1 X10 F100\nG3 X20 Y10 J10\nG2 X30 Y0 R10.5\nG18 G2 X40 Z10 I10 K0
G19 G3 Y10 Z20 J10 K0\nG17 G2 I-5 Z25\nG90.1 G3 X30 Y20 I30 J10\nG91.1 G91 G2 X5 Y5 R-8\nG20 G1 X.5\n",
    ),
    (
        "zeros of systems",
        "G55 G0 X1 Y1 Z1\nG1 X5 F100\nG59.2 X7\nG10 L2 P3 X100 Y5\nG56 X0 Y0\nG53 G0 X0\nG1 X3\nG54 Y9\n",
    ),
    (
        "local zeros",
        "G54 G1 X1 Y1 F100\nG52 X10 Y-4\nX1 Y1\nG55 X1\nG52 X0 Y0\nX3\n",
    ),
    (
        "shifts",
        "G54 G1 X1 Y1 F100\nG92 X50 Z2\nX52 Z3\nG55 X1\nG92 Y7\nY9\nG92.1\nX2\n",
    ),
    (
        "tool lengths",
        "G54 G0 X0 Y0 Z100\nT2 M6\nG43 H2 Z50\nG1 Z10 F100\nX20\nG49 G0 Z80\nG1 Z70\nG43 H3 Z20\nX0\n",
    ),
    (
        "cycles with both ends",
        "G54 G0 X0 Y0 Z50\nG99 G81 X10 Y10 Z-5 R2 F100\nX20\nG98 G82 X30 Z-6 R3 P0.1\nG85 X40 Z-2 R1\nG99 G89 Y20 Z-3 R2 P0.1
G80\nG0 Z60\nG91 G81 X5 Y1 Z-10 R-55 L3\nG90 G80\nG18 G81 X60 Z10 Y-5 R5\nG80 G17 G1 X0\n",
    ),
    (
        "reference points",
        "G54 G0 X10 Y10 Z10\nG1 X20 F100\nG91 G28 Z5\nG90 G1 X30 Y0 Z0\nG30 X5 Y5\nG1 Z3\n",
    ),
    (
        "subprograms of Fanuc",
        "G54 G0 X0 Y0 Z0\nM98 P200 L3\nG90 G1 X0 F100\nM98 P300\nM30\nO200\nG91 G1 X1 Y2 F100\nM98 P300\nM99\nO300\nG91 G3 X2 Y2 I2 F100\nM99\n",
    ),
    (
        "variables and arithmetic",
        "#1=2.5\n#2=[#1*4-3]\n#<depth>=[-#2/2]\n#4=2\n#[1+2]=##4\nG54 G0 X0 Y0 Z0\nG1 X[#1+#2] Y-#2 Z#<depth> F100\n",
    ),
    (
        "operators and functions",
        "#1=[1+2*3**2-8/4]\n#2=[SIN[30]+COS[60]*TAN[45]]\n#3=[SQRT[16]+ABS[-2.5]+ROUND[2.4]+FIX[2.9]+FUP[2.1]]
#4=[ASIN[0.5]+ACOS[0.5]+ATAN[1]/[1]+LN[EXP[1]]]\n#5=[17 MOD 5]\n#6=[#1 GT 5]\n#7=[2*[3+4]*5-6 MOD 4]
G54 G1 X#1 Y#2 Z#3 F100\nX#4 Y#5 Z#6\nX-#7 Y+#1 Z-[#1-#2]\n",
    ),
    (
        "loops and conditions of LinuxCNC",
        "G54 G0 X0 Y0 Z0\n#1=0\no1 while [#1 LT 10]\n#1=[#1+1]\no2 if [#1 EQ 3]\no1 continue\no2 elseif [#1 EQ 5]\nG1 X5 F100
o2 elseif [#1 EQ 6]\nG1 Y6 F100\no2 else\nG1 Z#1 F100\no2 endif\no3 if [#1 GT 8]\no1 break\no3 endif\nG1 X[#1*2] F100\no1 endwhile\nG1 X0 Y0\n",
    ),
    (
        "subprograms of LinuxCNC",
        "o100 sub\n#5=[#1*2]\nG1 X#5 Y#2 F100\no101 if [#1 GT 3]\no100 return [7]\no101 endif\nG1 Z#1\no100 endsub\no<ring> sub
#<r>=#1\nG91 G2 I-#<r> F100\nG90\no<ring> endsub\nG54 G0 X0 Y0 Z0\n#1=9\n#2=8\no100 call [2] [4]\no100 call [4] [5]\nG1 X#1 Y#2 Z#<_value>\no<ring> call [3]\n",
    ),
];

/// Programs of Siemens, and the same moves in the words of LinuxCNC.
pub(crate) const SIEMENS: &[(&str, &str, &str)] = &[
    (
        "coordinates with AC and IC, arcs with CR",
        "%_N_TEST_MPF\nN10 G54 G0 X=10 Y0 Z=AC(5) ; (X99)\nG1 X=IC(5) Y10 F500\nG91 X1 Y=AC(4)\nG90 G2 X=IC(4) Y8 CR=5\nG3 X30 Y0 CR=-12
G2 X=IC(10) Y10 I=AC(40) J=AC(0)\nG3 I-3 J=IC(2)\nG18 G2 X45 Z10 K5 I0\nM30\n",
        "G54 G0 X10 Y0 Z5\nG1 X15 Y10 F500\nX16 Y4\nG2 X20 Y8 R5\nG3 X30 Y0 R-12\nG90.1 G2 X40 Y10 I40 J0\nG91.1 G3 I-3 J2\nG18 G2 X45 Z10 K5 I0\n",
    ),
    (
        "zeros that are moved",
        "R1=2.5 R2=4\nG500 G0 X1 Y1 Z1\nG1 X2 F1000\nTRANS X10 Y=2*3\nX2 Y0\nATRANS X=-R1 Z1\nX3 Z2\nTRANS Z=R2\nX2 Y1 Z1\nG505 X2\nTRANS\nX3 Z1
G53 X5\nSUPA Y6 Z3\nX2 Y2\nM2\n",
        "G54 G0 X1 Y1 Z1\nG1 X2 F1000\nX12 Y6\nX10.5 Z3\nX2 Y1 Z5\nG58 X2\nX3 Z1\nG53 X5\nG53 Y6 Z3\nX2 Y2\n",
    ),
    (
        "tool lengths",
        "G54\nG0 X0 Y0\nT1\nM6\nG1 Z50 F1000\nT=\"DRILL\"\nM6\nX1\nZ20\nG0 SUPA Z0 D0\nG1 X5\nD1 Z10\nG53 Z100\nX6 D0\nZ5\n",
        "G54\nG0 X0 Y0\nG43 H1\nG1 Z50 F1000\nG43 H2\nX1\nZ20\nG49 G53 G0 Z0\nG1 X5\nG43 H2 Z10\nG53 Z150.8\nG49 X6\nZ5\n",
    ),
    (
        "cycles",
        "G54 G0 X0 Y0 Z50 F100\nCYCLE81(20, 0, 2, -10)\nX10\nCYCLE82(20,0,2,,12,0.5)\nMCALL CYCLE83(15,1,1,-8,,-3,,2,0,0,1,0)\nX20 Y5\nX=IC(5)\nMCALL\nX50\nZ30\nG1 X0\n",
        "G54 G0 X0 Y0 Z20 F100\nG98 G81 X0 Y0 Z-10 R2\nX10 Z-12\nG80\nG0 Z15\nG81 X20 Y5 Z-8 R2\nX25\nG80\nG0 X50\nZ30\nG1 X0\n",
    ),
    (
        "inches, words without effect, R parameters",
        "WORKPIECE(,,,\"BOX\")\nMSG(\"G1 X5 (\")\nG17 G40 G60 G90 G94 SOFT FFWON\nR1=SQRT(16)+POT(3)*SIN(30) R2=(1+2)*3\nG70 G54 G0 X=R1/10 Y0 Z0
G641 ADIS=0.01\nG1 X=R2/10 F20 S2=1000 M2=3\nG71 Y=ABS(-R2)+TRUNC(2.7)+ROUND(2.4)\nCYCLE832(0.01,1,1)\nM17\nX99\n",
        "G20 G54 G0 X.85 Y0 Z0\nG1 X.9 F20\nG21 Y13\n",
    ),
];
